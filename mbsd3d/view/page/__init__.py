"""The offline page and the live view."""
