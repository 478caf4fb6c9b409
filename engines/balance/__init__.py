"""Balance of reciprocating engines: closed form, sum of planar models and the whole engine in space, side by side.

`layouts` holds the engines, `phasor`, `planar_sum` and `spatial` compute them in three ways that share no equation,
`balance` compares these; `gas` and `shafts` add gas forces and balance shafts, `published` what was printed elsewhere.
"""
