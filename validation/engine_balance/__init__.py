"""Balance of reciprocating engines: closed form, sum of planar models and the whole engine in space, side by side."""
