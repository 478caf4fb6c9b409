"""Small motions about equilibria and steady motions."""
