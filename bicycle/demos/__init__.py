"""On the road."""
