"""Time integration: one file per method (interface in `method`), and the shared code of the compiled time loops."""
