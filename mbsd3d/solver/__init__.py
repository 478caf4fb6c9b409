"""The saddle point of masses and rows: joints of a spanning tree by what they leave free, then the rows of loops."""
