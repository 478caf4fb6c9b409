"""Time integration: a method is its table plus its order; the time loop is compiled."""
