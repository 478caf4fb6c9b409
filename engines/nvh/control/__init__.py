"""Active mounts: a damper to the sky, and feed-forward that cancels one order."""
