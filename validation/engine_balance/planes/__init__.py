"""How a spatial engine falls into planes, hypothesis by hypothesis; see ``validation.engine_balance.planes.reduction``.

What is judged is what mbsd3d computes with: primitives of joints, records of forces, terms of signals and the dense J
of ``mbsd3d.plain``, at the reference pose and its velocities. No run of mbsd3d is read: it remains a check of its own.
"""
