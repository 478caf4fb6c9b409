"""Active mounts: skyhook damping, and feed-forward that cancels one order."""
