"""Powertrains on elastic mounts: modes, small motions, the full motion."""
