"""Valve trains: cams with flat followers, float, bounce and the surge of springs."""
