"""Page that compares bicycles."""
