"""Demos: one file per effect that exists only in space, each checked against theory. See `base` for what one is."""
