"""One HTML file that needs nothing else: the scene of viser, a player, switches, and curves beside it."""
