"""Balance of reciprocating engines by three methods: closed form, sum of planar models, and the whole engine in space.

`layouts` holds the engines, `phasor`, `planar_sum` and `spatial` compute them in three ways that share no equation,
`balance` compares these; `gas` and `shafts` add gas forces and balance shafts, `published` what was printed elsewhere.
"""
