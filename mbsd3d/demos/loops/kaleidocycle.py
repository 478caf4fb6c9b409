"""A ring of six tetrahedra turns through its own centre, for ever."""

import numpy as np
from scipy.optimize import root_scalar

from mbsd3d import System, shapes

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .closed_loop import Loop, run_loop


def mechanism(*, a=0.1, alpha_deg=90.0, theta0_deg=-115.0, phi_guess_deg=43.0, turn_deg=215.0, misfit=0.0) -> System:
    """Build six equal sides with alternating twists alpha and 360 - alpha; misfit: one side longer by this share."""
    al, t = np.radians([alpha_deg, theta0_deg])
    f = other(np.array([t]), al, np.radians(phi_guess_deg))[0]
    loop = Loop((a,) * 6, (al, -al) * 3, (0,) * 6)
    return loop.system(loop.close(t, [f, t, f, t, f]), np.radians(turn_deg), misfit, look=tetrahedron)


def tetrahedron(start, end, axis, other, size):
    """Draw a tetrahedron whose two opposite edges are hinges, as long as their distance."""
    middle, half = 0.5 * (start + end), 0.5 * np.linalg.norm(end - start)
    corners = [place + side * half * way for place, way in ((start, axis), (end, other)) for side in (-1, 1)]
    return [shapes.Hull(np.array(corners) - middle)]


def closure(f, t, al):
    """Return the closure residual of the threefold-symmetric ring, zero where it closes."""
    c, s = np.cos(al), np.sin(al)
    same = c**2 + s**2 * (np.cos(t) + np.cos(f)) + (1 + c**2) * np.cos(t) * np.cos(f)
    return same - 2 * c * np.sin(t) * np.sin(f)


def other(path, al, guess):
    """Return the other hinges [rad] along a path of the driven one, continued from a guess."""
    found = []
    for t in path:
        near = found[-1] if found else guess
        root = root_scalar(closure, args=(t, al), x0=near, x1=near + 1e-3, xtol=1e-15)
        require(root.converged and abs(root.root - near) < 1, "demo 'kaleidocycle': the ring does not close at "
                f"{np.degrees(t):.4g} degrees; give another theta0_deg, phi_guess_deg or turn_deg")  # fmt: skip
        found.append(root.root)
    return np.array(found)


def theory(*, alpha_deg, theta0_deg, phi_guess_deg, misfit, turn_deg):
    """Solve cos^2 al + sin^2 al (cos t + cos f) + (1 + cos^2 al) cos t cos f - 2 cos al sin t sin f = 0, followed from
    t0.
    """
    require(
        misfit == 0,
        f"demo 'kaleidocycle': misfit = {misfit:g} locks the loop; theory is that of the one that closes, with 0",
    )
    al, t, guess, turn = np.radians([alpha_deg, theta0_deg, phi_guess_deg, turn_deg])
    path = other(t + turn * np.linspace(0, 1, 121), al, guess)
    return {"other_hinge_turn_deg": np.degrees(path[-1] - path[0])}


def measure(build, terms, *, alpha_deg, theta0_deg, phi_guess_deg) -> Measured:
    """Measure the turn of the hinges between the driven ones."""
    run, turns = run_loop(build(), **terms)
    al, t, guess = np.radians([alpha_deg, theta0_deg, phi_guess_deg])
    known = np.degrees(other(t + np.radians(turns[:, 0]), al, guess))
    curve = Curve("other hinges [deg]", turns[:, 0], turns[:, 1], (turns[:, 0], known - known[0]), "driven hinge [deg]")
    return Measured({"other_hinge_turn_deg": turns[-1, 1]}, [run], [curve])


demo = Demo(
    __name__,
    title="The kaleidocycle",
    question="Why can a ring of six tetrahedra be turned inside out for ever?",
    beats=(
        Beat(0.0, "A ring of six tetrahedra, each hinged to the next."),
        Beat(share(0.5), "It turns through its own middle ..."),
        Beat(share(1.0), "... inside out."),
    ),
    why="Six hinges in a ring just fail to give a degree of freedom: counting says none. But if each side is turned by "
    "a right angle against the next, three planes of symmetry make some of the conditions repeat others, and one "
    "degree of freedom is left. Bricard found such rings in 1897; folded of paper tetrahedra they turn through their "
    "own centre.",
    equation="right angles: cos t + cos f + cos t cos f = 0",
    symbols={
        "t": Symbol("turn of the driven hinges", "rad", curve=(0, 0)),
        "f": Symbol("turn of those between", "rad", curve=(1, 0)),
    },
    source="Chen, You, Tarnai, Int. J. Solids Struct. 42 (2005) 2287; Schattschneider, Walker, Kaleidocycles",
    quantities={"other_hinge_turn_deg": Quantity("turn of the hinges between", "deg")},
    ablation=Ablation(
        "symmetry",
        "one side is 1 % longer, and the ring is locked",
        {"misfit": 0.01},
        values=lambda: {"other_hinge_turn_deg": 0.0},
    ),  # fmt: skip
    show={
        "curves": [("angle", "hinge 1"), ("angle", "hinge 2")],
        "traces": [],
        "hidden": ["ground grid"],
        "speed": 0.3,
    },
    ranges={
        "alpha_deg": (89.0, 91.0),
        "theta0_deg": (-115.0, -112.0),
        "turn_deg": (180.0, 222.0),
        "phi_guess_deg": None,
        "misfit": None,
    },
    sliders=(Control("turn_deg", 30.0, 222.0, "deg", "turn of the first hinge"),),
    attempt="turn it farther: it goes through its own middle.",
)
