"""The trials of the suite: what is run, and who judges it."""
