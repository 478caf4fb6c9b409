"""Bodies that float."""
