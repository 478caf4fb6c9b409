"""Published figures of engines beside the true ones."""
