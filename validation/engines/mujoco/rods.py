"""Rods: spatial tendons held at their length."""

from typing import Any

from mbsd3d import Distance

from .build import Sketch


def add_rods(made: Sketch) -> list[tuple[Any, str, str]]:
    """(joint, tendon, equality) of every Distance."""
    found = []
    for joint in made.system.joints:
        if isinstance(joint, Distance):
            tendon = made.spec.add_tendon(name=f"rod {made.system.name(joint)}")
            for body, at in ((joint.a, joint.at_a), (joint.b, joint.at_b)):
                tendon.wrap_site(made.site(body, at))
            found.append((joint, tendon.name, made.equality("TENDON", tendon.name, (tendon.name, ""), "TENDON")))
    return found


def lengths(made: Sketch, model: Any, rods: list[tuple[Any, str, str]]) -> None:
    """An equality counts from the length in qpos0, the rod has its own."""
    for joint, tendon, equality in rods:
        model.eq_data[model.equality(equality).id, 0] = joint.length - model.tendon_length0[model.tendon(tendon).id]
