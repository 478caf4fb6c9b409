"""Pages of engines: one per engine with its animation, and an index."""
