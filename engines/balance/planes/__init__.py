"""Reduction of a spatial engine to planes, hypothesis by hypothesis; see ``engines.balance.planes.reduction``.

It judges what mbsd3d computes with: primitives of joints, records of forces, terms of signals and the dense J of the
plain equations, at the reference pose and its velocities. It reads no run of mbsd3d, so that it can check one.
"""
