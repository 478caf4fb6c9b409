"""Figures of rides and turns, and the page that compares bicycles."""
