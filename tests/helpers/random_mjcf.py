"""Random models as text of MJCF, of all that is built exactly: what an import is compared with is MuJoCo itself."""

import numpy as np

from helpers.mujoco_states import numbers

JOINTS = (("hinge",), ("slide",), ("ball",), ("hinge", "hinge"), ("slide", "hinge"), ("slide", "ball"), ("hinge",) * 3)
"""Joints of one body, from the parent on."""


def maybe(rng, text, chance=0.5):
    """A text, or nothing."""
    return text if rng.random() < chance else ""


def inertial(rng):
    """Mass, centre and inertia of a body that there could be, about axes of its own."""
    moments = np.sort(rng.uniform(0.05, 0.3, 3))
    moments[2] = min(moments[2], 0.95 * (moments[0] + moments[1]))
    place = f'pos="{numbers(0.1 * rng.normal(size=3))}" quat="{numbers(rng.normal(size=4))}"'
    return f'<inertial mass="{rng.uniform(0.4, 3.0)!r}" {place} diaginertia="{numbers(moments)}"/>'


def joint(rng, kind, name):
    """A joint with loads of its own; of single coordinates with a zero and a rest elsewhere."""
    loads = "".join(
        maybe(rng, f' {load}="{rng.uniform(0.1, most)!r}"')
        for load, most in (("stiffness", 5.0), ("damping", 0.5), ("armature", 0.6))
    )
    if kind in ("hinge", "slide"):
        loads += f' axis="{numbers(rng.normal(size=3))}"' + maybe(rng, f' ref="{rng.uniform(-0.5, 0.5)!r}"')
        loads += maybe(rng, f' springref="{rng.uniform(-0.5, 0.5)!r}"')
    return f'<joint name="{name}" type="{kind}" pos="{numbers(0.1 * rng.normal(size=3))}"{loads}/>'


def random_mjcf(seed):
    """(text, names of the bodies, whether two tendons are tied) of a random tree with tendons on its joints."""
    rng = np.random.default_rng(seed)
    count, inner, single = int(rng.integers(2, 8)), {}, []
    parents = [-1, *(int(rng.integers(-1, k)) for k in range(1, count))]
    for k in range(count):
        if parents[k] < 0 and rng.random() < 0.4:
            kinds, joints = ("free",), f'<joint name="j{k}" type="free" damping="{rng.uniform(0, 0.3)!r}"/>'
            joints = maybe(rng, joints) or f'<joint name="j{k}" type="free" armature="{rng.uniform(0.1, 0.5)!r}"/>'
        else:
            kinds = JOINTS[rng.integers(len(JOINTS))]
            joints = "".join(joint(rng, kind, f"j{k}{n}") for n, kind in enumerate(kinds))
            single += [f"j{k}{n}" for n, kind in enumerate(kinds) if kind in ("hinge", "slide")]
        inner[k] = joints + inertial(rng)
    bodies = dict.fromkeys(range(-1, count), "")
    for k in reversed(range(count)):
        place = f'pos="{numbers(0.4 * rng.normal(size=3))}" quat="{numbers(rng.normal(size=4))}"'
        more = maybe(rng, f' gravcomp="{rng.uniform(0.2, 1.5)!r}"', 0.3)
        bodies[parents[k]] += f'<body name="b{k}" {place}{more}>{inner[k]}{bodies[k]}</body>'
    tied = len(single) > 1 and rng.random() < 0.5
    made = [tendon(rng, name, single) for name in ("one", "two")] if single else []
    tendons = "".join(text for text, _ in made)
    tied = tied and len({x for _, some in made for x in some}) > 1  # a joint that follows itself is refused
    ties = f'<tendon tendon1="one" tendon2="two" polycoef="{numbers(TIE)}"/>' if tied else ""
    option = f'gravity="{numbers(5.0 * rng.normal(size=3))}"' + maybe(rng, ' density="1.2" viscosity="0.3"', 0.3)
    text = f"""<mujoco><compiler angle="radian"/><option {option}/><worldbody>{bodies[-1]}</worldbody>
      <tendon>{tendons}</tendon><equality>{ties}</equality></mujoco>"""
    return text, [f"b{k}" for k in range(count)], tied


TIE = np.array([0.05, 0.4, 0.3, -0.1, 0.0])
"""Polynomial by which the first tendon follows the second one."""


def tendon(rng, name, joints):
    """(text, joints) of a fixed tendon on some of the joints, with or without spring and damper."""
    some = [x for x in joints if rng.random() < 0.7] or joints[:1]
    terms = "".join(
        f'<joint joint="{x}" coef="{numbers([rng.uniform(0.3, 1.2) * rng.choice([1, -1])])}"/>' for x in some
    )
    loads = maybe(rng, f' stiffness="{rng.uniform(1.0, 9.0)!r}"') + maybe(rng, f' damping="{rng.uniform(0.1, 1.0)!r}"')
    loads += maybe(rng, f' armature="{rng.uniform(0.1, 1.0)!r}"', 0.5) if len(some) == 1 else ""
    return f'<fixed name="{name}"{loads}>{terms}</fixed>', some
