"""Offline pages and live views."""
