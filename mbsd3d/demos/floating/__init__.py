"""Bodies that float."""

PLACE = 2
