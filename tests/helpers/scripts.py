"""Scripts as users write them, for tests of commands."""

PENDULUM = """
from mbsd3d import GROUND, Body, Revolute, System

def build():
    bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0, 0.6, -0.8), orientation=(1, 0, 0, 0))
    return System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(1, 0, 0), name="hinge")])
"""
