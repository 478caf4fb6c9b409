"""Solve the saddle point of masses and constraint rows: eliminate a spanning tree, then the rows that close loops."""
