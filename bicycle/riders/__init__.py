"""Who steers: a rider of five loops, what it costs to ride so, and balance assist."""
