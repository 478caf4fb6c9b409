"""A model that is played in a browser: a page with sliders, keys, the moving scene and live curves, and its server."""
