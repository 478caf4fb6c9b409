"""A page per engine with its animation, and an index."""
