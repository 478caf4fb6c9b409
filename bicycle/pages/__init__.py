"""The page that compares bicycles."""
