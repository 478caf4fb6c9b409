"""Closed loops from their textbook parameters: they close, they have the freedom they are known for, or say why not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from mbsd3d import AngleDriver, Cylindrical, Kinematic, PointOnLine, System, linkages, rotation, simulate
from mbsd3d.rotations import matrix
from mbsd3d.signals import Ramp
from validation import cases
from validation.cases.loops import FAMILIES, parts

BASE = {"position": (0.4, -1.2, 0.7), "orientation": rotation((0.3, 1.0, -0.5), 0.8)}
PULL = (0.3, -0.7, -9.6)


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("seed", range(3))
def test_a_loop_closes_with_one_freedom(name, seed):
    system = FAMILIES[name](np.random.default_rng(seed))
    found = system.check()
    assert found.mobility == found.velocity_freedom == 1
    assert found.redundant == 7 - len(system.joints)  # n hinges would leave n - 6


def test_the_orthogonal_bricard_is_that_of_the_library():
    """The same points and axes up to a displacement: all their distances and angles."""

    def shape(joints):
        at, axis = np.array([j.at for j in joints]), np.array([j.axis for j in joints])
        return (
            np.linalg.norm(at[:, None] - at, axis=2),
            np.abs(axis @ axis.T),
            np.abs(axis @ (at[:, None] - at[0])[:, 0].T),
        )

    ours, known = linkages.bricard(1.0, np.pi / 2, **BASE), cases.load("iftomm_A04_bricard").system
    for a, b in zip(shape(ours.joints), shape(known.joints), strict=True):
        assert np.allclose(a, b, rtol=0, atol=1e-14)


def test_the_bricard_of_equal_links_is_line_and_plane_symmetric():
    theta, right = 1.1, np.pi / 2
    phi = np.arccos(-np.cos(theta) / (1 + np.cos(theta)))
    known = linkages.bricard(0.7, theta)
    alike = [
        linkages.hinge_loop([0.7] * 6, [right, -right] * 3, [0] * 6, [theta, phi] * 3),
        linkages.bricard_plane([0.7] * 3, [right, -right, right], (0, 0), theta, near=(phi, theta, phi)),
    ]
    for system in alike:
        for ours, theirs in zip(system.joints, known.joints, strict=True):
            assert np.allclose(ours.at, theirs.at, rtol=0, atol=1e-12) and np.allclose(
                ours.axis, theirs.axis, rtol=0, atol=1e-12
            )


@pytest.mark.parametrize(
    "system",
    [
        linkages.bennett(0.7, 0.6, 0.7 * np.sin(1.9) / np.sin(0.6), 1.9, 0.9, **BASE, gravity=PULL),
        linkages.sarrus((0.5, 0.6), (0.45, 0.7), 1.9, 0.8, reach=0.2, **BASE, gravity=PULL),
        linkages.rssr(0.2, 0.75, 0.45, 0.6, 1.2, 0.4, offsets=(0.05, -0.1), **BASE, gravity=PULL),
    ],
    ids=["bennett", "sarrus", "rssr"],
)
def test_bars_reach_from_hinge_to_hinge(system):
    """A bar's centre of mass lies between its hinges, its inertia is smallest along it; gravity is as given."""
    assert tuple(system.gravity) == PULL
    for body, near, far in zip(system.bodies, system.joints[:-1], system.joints[1:], strict=True):
        centre = body.position + matrix(body.orientation) @ body.com
        assert np.allclose(centre, 0.5 * (near.at + far.at), rtol=0, atol=1e-14)
        if (len(system.joints), body.name) == (6, "link 3"):
            continue  # the platform of Sarrus' linkage, with its mass in the middle between its hinges
        along = matrix(body.orientation).T @ (far.at - near.at)
        moments, axes = np.linalg.eigh(body.inertia)
        assert moments[0] < 0.5 * moments[1]
        assert abs(axes[:, 0] @ along) == pytest.approx(np.linalg.norm(along), rel=1e-12)


def test_links_keep_what_they_are_given():
    links = parts(np.random.default_rng(5), 5)
    system = linkages.schatz(0.4, 0.7, offset=0.15, links=links, **BASE)
    for body, link in zip(system.bodies, links, strict=True):
        assert (body.mass, *body.com) == (link.mass, *link.com)
        assert np.allclose(body.inertia, link.inertia, rtol=0, atol=1e-16)  # made symmetric: an ulp of 0.3


@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("spin", [False, True])
def test_rssr_meets_its_loop_equation(branch, spin):
    """Driven over a turn: the angle of the rocker by a root of |p - q|^2 = rod^2, followed from its start."""
    crank, rod, rocker, distance, twist, offsets, start = 0.2, 0.75, 0.45, 0.6, 1.2, (0.05, -0.1), 0.4
    system = linkages.rssr(
        crank, rod, rocker, distance, twist, start, offsets=offsets, branch=branch, spin=spin, **BASE
    )
    assert system.check().mobility == 1 + spin
    if spin:
        return
    rod_pin, shaft = system.joints[2:]
    assert np.allclose(rod_pin.axis_b, shaft.axis, rtol=0, atol=1e-15)  # the cross along the rocker's shaft,
    assert abs(rod_pin.axis_a @ (rod_pin.at - system.joints[1].at)) < 1e-15  # and across the rod
    driven = System(system.bodies, [*system.joints, AngleDriver(system.joints[0], Ramp(2.0))])
    solution = simulate(driven, 3.0, method=Kinematic(), output=61)

    def reach(psi, theta):
        pin = np.array([crank * np.cos(theta), crank * np.sin(theta), offsets[0]])
        c, s = np.cos(twist), np.sin(twist)
        x, y, z = rocker * np.cos(psi), rocker * np.sin(psi), offsets[1]
        return np.linalg.norm([distance + x, c * y - s * z, s * y + c * z] - pin) - rod

    grid = np.linspace(-np.pi, np.pi, 400)
    values = [reach(psi, start) for psi in grid]
    roots = [brentq(reach, a, b, args=(start,), xtol=1e-14) for a, b, u, v in
             zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True) if u * v < 0]  # fmt: skip
    assert len(roots) == 2
    turned = solution.angle(system.joints[3])
    errors = []
    for root in roots:
        psi = [root]
        for t in solution.t[1:]:
            psi.append(brentq(reach, psi[-1] - 0.15, psi[-1] + 0.15, args=(start + 2.0 * t,), xtol=1e-14))
        errors.append(np.abs(turned - turned[0] - (np.array(psi) - psi[0])).max())
    assert min(errors) < 1e-9 < max(errors)
    psi = roots[int(np.argmin(errors))]  # |p - q| grows with the sine of psi seen from atan2(F, E)
    assert np.sign(reach(psi + 1e-6, start) - reach(psi - 1e-6, start)) == branch


@pytest.mark.parametrize("near", [0.0, np.pi, -np.pi])
@pytest.mark.parametrize("way", [1e-12, 1e-9, -1e-6, 3e-5, -1e-3])
def test_schatz_closes_however_near_to_its_dead_centre(near, way):
    """There theta_3 passes 0: x of link 3 turns from that of link 2 by -2 atan(sqrt(3) sin(theta_1)), exactly."""
    system = linkages.schatz(0.37, near + way, offset=0.15, **BASE)
    x, other = (matrix(system.bodies[k].orientation)[:, 0] for k in (1, 2))
    assert np.linalg.norm(other - x) == pytest.approx(2 * abs(np.sin(np.arctan(np.sqrt(3) * np.sin(way)))), abs=1e-14)
    assert system.check().mobility == 1


def test_sarrus_goes_straight():
    """Along z of its frame, without turning."""
    system = linkages.sarrus((0.5, 0.6), (0.55, 0.62), 1.9, 0.8, reach=0.2, **BASE)
    solution = simulate(system, 0.5, state=system.assemble(rates={"hinge 1": 1.0}), output=11)
    path = solution.position("link 3") - solution.position("link 3")[0]
    up = matrix(BASE["orientation"])[:, 2]
    assert np.abs(path @ up).max() > 0.1
    assert np.abs(path - np.outer(path @ up, up)).max() < 1e-12
    assert np.abs(solution.omega("link 3")).max() < 1e-12


@pytest.mark.parametrize(
    ("system", "cut"),
    [
        (linkages.bennett(0.7, 0.6, 0.7 * np.sin(1.9) / np.sin(0.6), 1.9, 0.9, **BASE), PointOnLine),
        (linkages.bricard(1.0, 1.3, **BASE), Cylindrical),
        (FAMILIES["bricard_plane"](np.random.default_rng(2)), Cylindrical),
    ],
    ids=["bennett", "bricard", "plane"],
)
def test_rows_that_repeat_others_cost_neither_steps_nor_digits(system, cut):
    """The same motion with the last hinge cut open until no row repeats another."""
    last = system.joints[-1]
    twin = replace(system, joints=[*system.joints[:-1], cut(last.a, last.b, at=last.at, axis=last.axis)])
    assert twin.check().redundant == 0 < system.check().redundant
    for rtol in (1e-5, 1e-8):
        runs = [simulate(x, 2.0, state=x.assemble(rates={"hinge 1": 2.0}), rtol=rtol, output=5) for x in (system, twin)]
        (steps, lost), (known, least) = ((run.certificate.steps, np.ptp(run.energy().total)) for run in runs)
        # step control sees other coordinates of the same motion; fewer steps of order 8 lose more by their eighth power
        assert steps <= 1.3 * known + 1 and lost < 10 * least * max(1.0, known / steps) ** 8, (
            steps,
            known,
            lost,
            least,
        )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: linkages.bennett(0.7, 0.6, 1.2, 1.9, 0.9),
            "a / sin.alpha. = b / sin.beta. does not hold .* 1.1731495",
        ),
        (lambda: linkages.bennett(0.7, 0.6, 0.7, 0.6, 0.9), "equal links"),
        (lambda: linkages.bennett(0.0, 0.6, 0.0, 1.9, 0.9), "lengths other than 0"),
        (lambda: linkages.bennett(0.7, 0.0, 0.7, 0.6, 0.9), "not multiples of pi"),
        (lambda: linkages.bennett(0.7, 0.6, 0.7 * np.sin(1.9) / np.sin(0.6), 1.9, 0.0), "folds the loop"),
        (lambda: linkages.goldberg(0.7, 0.6, 0.7 * np.sin(1.9) / np.sin(0.6), 1.9, 0.5, 1.1, 0.9), "c, gamma"),
        (lambda: linkages.myard(0.7, 0.6, 1.0, 0.9), "goes with 1.2397225"),
        (lambda: linkages.bricard(1.0, 2.2), "between -120 and 120"),
        (lambda: linkages.bricard_line((1, 1), (1, 1), (0, 0), 0.3), "give one of each a link"),
        (lambda: linkages.bricard_line((1, 1, 0.1), (0.1, 0.2, 0.1), (9, 0, 0), 0.3), "no closed pose"),
        (lambda: linkages.bricard_plane((1, 1, 1), (1, 1, 1), (0, 0), 0.3, near=(0, 0)), "near has 2 angles; give 3"),
        (lambda: linkages.schatz(-1.0, 0.3), "length: -1.0 is not positive; give a number > 0"),
        (lambda: linkages.sarrus((0.5, 0.1), (0.5, 0.5), 1.0, 0.3), "steeper angle"),
        (lambda: linkages.sarrus((0.5, 0.5), (0.2, 0.2), 1.0, 1.0), "second leg .* does not reach"),
        (lambda: linkages.sarrus((0.5, 0.5), (0.5, 0.5), 0.0, 1.0), "in one plane"),
        (lambda: linkages.rssr(0.2, 3.0, 0.5, 0.6, 1.3, 0.4), "the rod is 3 m"),
        (lambda: linkages.hinge_loop((1, 1, 1), (0.1, 0, 0), (0, 0, 0), (0.1, 0.2, 0.3)), "m and .* rad apart"),
        (lambda: linkages.hinge_loop((1, 1, 1), (0, 0, 0.3), (0, 0, 0), [2 * np.pi / 3] * 3), "m and 0.299 rad apart"),
        # folded as it is, this loop has two degrees of freedom wherever it closes
        (
            lambda: linkages.bricard_line((1, 1, 1), (np.pi / 2, -np.pi / 2, np.pi / 2), (0, 0, 0), 0.9),
            "no closed pose",
        ),
        (lambda: linkages.schatz(0.4, 0.7, links=parts(np.random.default_rng(0), 4)), "4 links given; it has 5"),
    ],
)
def test_what_does_not_close_says_why(make, words):
    with pytest.raises(ValueError, match=words):
        make()
