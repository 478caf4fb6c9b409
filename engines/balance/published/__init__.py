"""Published figures of engines compared with the true ones."""
