"""Hinges of loops count their turns on the way to what is asked for: closed forms over many turns, sizes and places."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    AssemblyError,
    Body,
    Constant,
    CurveContact,
    Cylindrical,
    Gear,
    GearMesh,
    Kinematic,
    Prismatic,
    RackPinion,
    Ramp,
    Revolute,
    Screw,
    SlideDriver,
    System,
    TorsionSpring,
    accelerations,
    linkages,
    load,
    measures,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

TURNS = 2.0 * np.pi


class Place:
    """A frame with general axes; ``size`` [m] of what is built there, ``far`` [m] from the origin."""

    def __init__(self, seed, size=1.0, far=0.0):
        self.random = np.random.default_rng(seed)
        self.R = matrix(rotation(self.random.normal(size=3), 2.0))
        self.origin, self.size = self.random.normal(size=3) * size + far, size
        self.rounding = 1e-10 * max(1.0, far / size)  # of positions far away, over the size of the mechanism

    def at(self, *x):
        return self.origin + self.size * self.R @ np.array(x, float)

    def to(self, *x):
        return self.R @ np.array(x, float) / np.linalg.norm(x)

    def body(self, name, *x, mass=1.3):
        """A body near a point, turned, with its centre of mass off its reference point."""
        random, size = self.random, self.size
        return Body(
            name, mass, np.array([0.02, 0.05, 0.06]) * size**2, com=0.03 * size * random.normal(size=3),
            position=self.at(*x) + 0.1 * size * random.normal(size=3),
            orientation=rotation(random.normal(size=3), random.uniform(0.0, 3.0)),
        )  # fmt: skip

    def mixed(self, bodies, joints, forces=()):
        """A system with its bodies in any order."""
        return System([bodies[i] for i in self.random.permutation(len(bodies))], joints, forces)


def turned(system, state, *names):
    """Angles [rad] or slides [m] of joints at a state."""
    found, joints = accelerations(system, state), [system.part(name, "joints") for name in names]
    return np.array([(found.slide if isinstance(x, Prismatic) else found.angle)(x)[0] for x in joints])


def spindle(place, pitch, *more):
    """Spindle on a hinge, nut on a slide, a thread between: nut = -pitch / (2 pi) spindle."""
    axis, bodies = place.to(0, 0, 1), [place.body("spindle", 0, 0, 0), place.body("nut", 0.2, 0.1, 0)]
    hinge = Revolute(GROUND, bodies[0], at=place.at(0, 0, 0), axis=axis, name="hinge")
    rail = Prismatic(GROUND, bodies[1], at=place.at(0.1, 0, 0), axis=axis, name="rail")
    thread = Screw(*bodies, at=place.at(0, 0, 0.1), axis=axis, pitch=pitch * place.size, name="thread")
    return place.mixed(bodies, [hinge, rail, thread, *(driver(hinge, rail) for driver in more)])


@pytest.mark.parametrize(
    ("size", "far", "pitch", "angle"),
    [(1.0, 0.0, 0.01, 10.0), (1.0, 100.0, -0.037, -43.0), (1e-3, 0.0, 0.02, 7.7), (1e-3, 0.1, 0.05, -1e4)],
)
def test_a_lead_screw_over_many_turns(size, far, pitch, angle):
    """The issue: 10 rad at a pitch of 10 mm put the nut at -0.0159155 m; by angle, slide, measure, drivers, nearby."""
    place = Place(1, size, far)
    system, way = spindle(place, pitch), -angle * pitch / TURNS * size
    limit = dict(rel=place.rounding, abs=place.rounding * size)
    nut = system.part("nut")
    assert turned(system, system.assemble(angles={"hinge": angle}), "rail")[0] == pytest.approx(way, **limit)
    along = measures.position(nut, axis=place.to(0, 0, 1))
    driven = spindle(Place(1, size, far), pitch, lambda hinge, rail: SlideDriver(rail, Constant(way)))
    for model, state in (
        (system, system.assemble(slides={"rail": way})),
        (system, system.assemble(measures={along: float(nut.centre @ along.axis) + way})),
        (system, system.assemble(slides={"rail": way}, near=system.assemble(angles={"hinge": 300.0}))),
        (system, system.assemble(slides={"rail": way}, angles={"hinge": angle})),
        (driven, driven.assemble()),
    ):
        screwed = turned(model, state, "hinge", "thread")
        assert screwed == pytest.approx([angle, -angle], rel=1e3 * place.rounding)  # a turn is a small part of the size


def test_what_contradicts_a_coupling_names_both():
    system = spindle(Place(2), 0.01)
    with pytest.raises(AssemblyError, match="angle of 'hinge', slide of 'rail', a gap remains"):
        system.assemble(angles={"hinge": 10.0}, slides={"rail": -10.0 * 0.01 / TURNS + 0.01})  # off by one turn


@pytest.mark.parametrize(("ratio", "angle"), [(10.0, 1.0), (-3.0, 3.1), (7.3, -12.0), (-0.13, 40.0)])
def test_a_gear_starts_at_what_its_driver_says(ratio, angle):
    place = Place(3)
    one, two = place.body("one", 0, 0, 0), place.body("two", 0.3, 0, 0)
    a = Revolute(GROUND, one, at=place.at(0, 0, 0), axis=place.to(1, 2, 3), name="a")
    b = Revolute(two, GROUND, at=place.at(0.3, 0, 0), axis=place.to(0, -1, 2), name="b")
    motor = AngleDriver(a, Constant(angle) + Ramp(2.0))
    system = place.mixed([one, two], [a, b, Gear(a, b, ratio=ratio), motor])
    state = system.assemble()
    assert turned(system, state, "a", "b") == pytest.approx([angle, ratio * angle], abs=1e-11)
    run = simulate(system, 3.0, state=state, method=Kinematic(), output=4)
    assert run.certificate.passed
    assert run.angle("b") == pytest.approx(ratio * (angle + 2.0 * run.t), abs=1e-9)
    stop = simulate(system, 3.0, state=state, stop_when=measures.angle(a) > angle + 1.0)
    assert stop.t[-1] == pytest.approx(0.5, abs=1e-7)  # tolerance of the run
    with pytest.raises(AssemblyError, match=f"AngleDriver.*residual {abs(angle):.3g}.*start from system.assemble"):
        system.state()


def test_a_rack_starts_at_what_its_driver_says():
    place = Place(4)
    wheel, bar = place.body("wheel", 0, 0, 0), place.body("bar", 0, 0.3, 0)
    a = Revolute(GROUND, wheel, at=place.at(0, 0, 0), axis=place.to(0, 0, 1), name="a")
    rail = Prismatic(GROUND, bar, at=place.at(0, 0.05, 0), axis=place.to(1, 0, 0), name="rail")
    system = place.mixed([wheel, bar], [a, rail, RackPinion(a, rail, radius=0.05), SlideDriver(rail, Constant(0.5))])
    assert turned(system, system.assemble(), "a")[0] == pytest.approx(10.0, abs=1e-11)


@pytest.mark.parametrize("way", ["a", "b", "rail", "measure"])
def test_couplings_in_series_from_either_end(way):
    place, ratios, angle = Place(5), (-2.3, 0.41, 9.0), -11.0
    bodies = [place.body(f"wheel {k}", 0.3 * k, 0, 0) for k in range(4)] + [place.body("bar", 0, 1, 0)]
    hinges = [
        Revolute(GROUND, bodies[k], at=place.at(0.3 * k, 0, 0), axis=place.to(*place.random.normal(size=3)), name=x)
        for k, x in enumerate("abcd")
    ]
    rail = Prismatic(GROUND, bodies[4], at=place.at(0, 1, 0), axis=place.to(1, 1, 2), name="rail")
    gears = [Gear(hinges[k], hinges[k + 1], ratio=ratio) for k, ratio in enumerate(ratios)]
    system = place.mixed(bodies, [*hinges, rail, *gears, RackPinion(hinges[3], rail, radius=0.03)])
    expected = angle * np.cumprod([1.0, *ratios, 0.03])
    asked = {
        "a": {"angles": {"a": expected[0]}},
        "b": {"angles": {"b": expected[1]}},
        "rail": {"slides": {rail: expected[4]}},
        "measure": {"measures": {measures.angle(hinges[2]): expected[2]}},
    }
    state = system.assemble(**asked[way])
    assert turned(system, state, *"abcd", "rail") == pytest.approx(expected, rel=1e-8)  # a measure is met to 1e-8


def planetary(place, teeth, module, helix=0.1):
    """Sun, ring and carrier on one axis, a planet on the carrier."""
    z_sun, z_planet = teeth
    r_sun, r_planet = z_sun * module / 2.0, z_planet * module / 2.0
    r_ring, out, z = r_sun + 2.0 * r_planet, r_sun + r_planet, place.to(0, 0, 1)
    sun, ring, arm = (place.body(name, 0, 0, 0) for name in ("sun body", "ring body", "arm"))
    planet = place.body("planet body", out, 0, 0)
    shafts = [
        Revolute(GROUND, body, at=place.at(0, 0, 0.1), axis=z, name=name)
        for name, body in (("sun", sun), ("ring", ring), ("carrier", arm))
    ]
    pin = Revolute(arm, planet, at=place.at(out, 0, 0), axis=z, name="planet")
    meshes = [
        GearMesh(shafts[0], pin, at=place.at(r_sun, 0, 0), carrier=arm, helix_angle=helix),
        GearMesh(pin, shafts[1], at=place.at(r_ring, 0, 0), carrier=arm, helix_angle=-helix),
    ]
    return place.mixed([sun, ring, arm, planet], [*shafts, pin, *meshes])


@pytest.mark.parametrize(
    ("teeth", "sun", "ring"), [((17, 12), 10.0, 0.0), ((23, 31), -77.0, 14.0), ((12, 18), 1e4, -2e3)]
)
def test_planetary_gear_as_willis_says(teeth, sun, ring):
    """The issue: 17/12/41, ring at rest, sun 10 rad: carrier 2.931 rad."""
    place = Place(6)
    system = planetary(place, teeth, 0.01)
    z_ring = teeth[0] + 2 * teeth[1]
    carrier = (teeth[0] * sun + z_ring * ring) / (teeth[0] + z_ring)
    planet = -(sun - carrier) * teeth[0] / teeth[1]
    by_sun = system.assemble(angles={"sun": sun, "ring": ring})
    assert turned(system, by_sun, "carrier", "planet") == pytest.approx([carrier, planet], rel=1e-11)
    by_planet = system.assemble(angles={"planet": planet, "ring": ring})
    assert turned(system, by_planet, "sun") == pytest.approx([sun], rel=1e-11)
    if not ring:
        held = system.assemble(angles={"sun": sun}, pinned=[system.part("ring body")])
        assert turned(system, held, "carrier") == pytest.approx([carrier], rel=1e-11)


def differential(place, order=(0, 1, 2, 3, 4, 5, 6, 7)):
    """A cage with a spider gear; the wheels turn on the ground too."""
    x, z, middle = place.to(1, 0, 0), place.to(0, 0, 1), place.at(0, 0, 0)
    cage, left, right, spider = (place.body(name, s, 0, 0) for name, s in (("k", 0), ("l", -0.2), ("r", 0.2), ("s", 0)))
    main, pin = Revolute(GROUND, cage, at=middle, axis=x, name="cage"), Revolute(cage, spider, at=middle, axis=z)
    wheels = [Revolute(GROUND, w, at=middle, axis=x, name=n) for n, w in (("left", left), ("right", right))]
    sides = [Revolute(cage, body, at=middle, axis=x) for body in (left, right)]
    joints = [main, pin, *wheels, *sides, Gear(pin, sides[0], ratio=1.0), Gear(pin, sides[1], ratio=-1.0)]
    return place.mixed([cage, left, right, spider], [joints[i] for i in order])


@pytest.mark.parametrize(("left", "right"), [(4.0, 2.0), (-31.0, 12.0), (250.0, 249.0)])
def test_a_cage_turns_by_the_mean_of_its_wheels(left, right):
    system = differential(Place(7))
    state = system.assemble(angles={"left": left, "right": right})
    assert turned(system, state, "cage")[0] == pytest.approx((left + right) / 2.0, rel=1e-12)
    assert state.notes == ()


def test_what_is_not_determined_is_said():
    """One wheel asked for leaves the other: least motion where no turn depends on it, in any order; else an error."""
    orders = [np.random.default_rng(k).permutation(8) for k in range(3)]
    systems = [differential(Place(8 + k), order) for k, order in enumerate(orders)]
    states = [system.assemble(angles={"left": 2.0}) for system in systems]
    found = [turned(*pair, "cage", "right") for pair in zip(systems, states, strict=True)]
    assert found[1:] == [pytest.approx(found[0], abs=1e-12)] * 2
    assert all("leaves a choice" in state.notes[0] and "'right' by" in state.notes[0] for state in states)
    run = simulate(systems[0], 1e-3, state=states[0])
    assert any(note.startswith("start: what is asked for leaves a choice") for note in run.certificate.notes)
    with pytest.raises(AssemblyError, match="leaves open how often '.*' turns.* ask for its angle"):
        systems[0].assemble(angles={"left": 40.0})


def test_notes_survive_a_file(tmp_path):
    system = differential(Place(9))
    run = simulate(system, 1e-3, state=system.assemble(angles={"left": 2.0}))
    assert load(run.save(tmp_path / "run.npz")).certificate.notes == run.certificate.notes


def parallelogram(place, crank, *more):
    """Crank, coupler, rocker; a motor beside it; springs that count turns on the pins of the coupler."""
    z, tip = place.to(0, 0, 1), 0.2 * np.array([np.cos(crank), np.sin(crank), 0.0])
    bodies = [place.body(name, *x) for name, x in (("c", tip), ("k", tip), ("r", (0.5, 0, 0)), ("m", (0, -0.4, 0)))]
    ends = ((GROUND, 0, (0, 0, 0), "crank"), (0, 1, tip, "pin"), (1, 2, tip + (0.5, 0, 0), "eye"),
            (GROUND, 2, (0.5, 0, 0), "rocker"), (GROUND, 3, (0, -0.4, 0), "motor"))  # fmt: skip
    hinges = [
        Revolute(a if a is GROUND else bodies[a], bodies[b], at=place.at(*x), axis=z, name=name)
        for a, b, x, name in ends
    ]
    joints = [*hinges, Gear(hinges[4], hinges[0], ratio=-0.31), *(driver(hinges[0]) for driver in more)]
    spring = TorsionSpring(hinges[1], stiffness=1.7, name="spring")
    return place.mixed(bodies, joints, [spring]), z


@pytest.mark.parametrize(("size", "far", "angle"), [(1.0, 0.0, 4.0), (1.0, 100.0, -19.0), (1e-2, 0.0, 333.0)])
def test_a_spring_in_a_parallelogram_counts_turns(size, far, angle):
    """The issue: crank 4 rad, k = 1 at a coupler pin: 4 N m."""
    place = Place(10, size, far)
    system, axis = parallelogram(place, 1.1)
    limit = dict(abs=1e3 * place.rounding, rel=place.rounding)
    for state in (system.assemble(angles={"crank": angle}), system.assemble(angles={"motor": -angle / 0.31})):
        assert turned(system, state, "crank", "pin", "eye", "rocker") == pytest.approx(
            np.array([1.0, -1.0, 1.0, 1.0]) * angle, **limit
        )
        moment = accelerations(system, state).force("spring").moment[0]
        assert moment @ axis == pytest.approx(1.7 * angle, **limit)
    run = simulate(system, 1e-6, state=state)
    assert run.angle("pin")[-1] == pytest.approx(-angle, abs=1e-4)  # the springs move it a little


def test_whole_turns_of_a_driver_leave_the_reference_pose():
    """state() is the reference pose: two turns of the crank lead back to it, with all hinges turned."""
    system, _ = parallelogram(Place(11), 0.8, lambda crank: AngleDriver(crank, Constant(2 * TURNS)))
    with pytest.raises(AssemblyError, match="AngleDriver"):
        system.state()  # the motor, at -0.31 of the crank, does not come back
    loop = linkages.bennett(0.3, 1.4, 0.2, np.arcsin(0.2 / 0.3 * np.sin(1.4)), angle=1.2)
    driven = System(loop.bodies, [*loop.joints, AngleDriver(loop.joints[0], Constant(-2 * TURNS))])
    state = driven.state(as_built=1e-5)
    np.testing.assert_array_equal(state.q, loop.state().q)
    assert np.abs(turned(driven, state, "hinge 1", "hinge 2")) == pytest.approx([2 * TURNS] * 2, abs=1e-9)


def four_bar(place, a, b, c, d, start):
    """Planar four-bar of hinges, redundant in space, and its angles (pin, eye, rocker) after a turn of the crank."""

    def links(crank):
        tip = a * np.array([np.cos(crank), np.sin(crank)])
        gap = np.array([d, 0.0]) - tip
        length = np.hypot(*gap)
        coupler = np.arctan2(gap[1], gap[0]) + np.arccos((b * b + length**2 - c * c) / (2 * b * length))
        eye = tip + b * np.array([np.cos(coupler), np.sin(coupler)])
        return tip, eye, coupler, np.arctan2(eye[1], eye[0] - d)

    tip, eye, _, _ = links(start)
    z, bodies = place.to(0, 0, 1), [place.body("c", *tip, 0), place.body("k", *eye, 0), place.body("r", d, 0, 0)]
    ends = ((GROUND, 0, (0, 0), "crank"), (0, 1, tip, "pin"), (1, 2, eye, "eye"), (GROUND, 2, (d, 0), "rocker"))
    hinges = [
        Revolute(x if x is GROUND else bodies[x], bodies[y], at=place.at(*p, 0), axis=z, name=name)
        for x, y, p, name in ends
    ]

    def after(turn):
        way = [links(x)[2:] for x in np.linspace(start, start + turn, 200 + int(100 * abs(turn)))]
        coupler, rocker = np.diff(np.unwrap(way, axis=0)[[0, -1]], axis=0)[0]
        return coupler - turn, rocker - coupler, rocker

    return place.mixed(bodies, hinges), after


@pytest.mark.parametrize(
    ("lengths", "turn"),
    [((0.1, 0.4, 0.35, 0.45), -22.0), ((0.3, 0.35, 0.4, 0.12), 17.0), ((0.2, 0.5, 0.3, 0.55), -9.0)],
    ids=["crank-rocker", "drag-link", "near its limit"],
)
def test_four_bars_over_many_turns(lengths, turn):
    place = Place(12)
    system, after = four_bar(place, *lengths, 0.9)
    state = system.assemble(angles={"crank": turn})
    assert turned(system, state, "pin", "eye", "rocker") == pytest.approx(after(turn), abs=1e-10)
    driven = System(
        system.bodies, [*system.joints, AngleDriver(system.part("crank", "joints"), Constant(turn) + Ramp(1.0))]
    )
    assert turned(driven, driven.assemble(), "pin", "eye", "rocker") == pytest.approx(after(turn), abs=1e-10)


def test_a_cam_counts_the_way_along_its_curve():
    """A pin on an eccentric disc: R times the angle by which it goes around, from the geometry of the disc."""
    R, off, turn = 0.03, 0.01, np.linspace(0.0, TURNS, 72, endpoint=False)
    disc = np.column_stack([off + R * np.cos(turn), R * np.sin(turn), 0.0 * turn])
    height = np.sqrt(R * R - off * off)
    cam, valve = Body("cam", 1.0, (1e-3,) * 3), Body("valve", 0.1, (1e-5,) * 3, position=(0, height, 0))
    shaft = Revolute(GROUND, cam, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    guide = Prismatic(GROUND, valve, at=(0, 0, 0), axis=(0, 1, 0), name="guide")
    system = System([cam, valve], [shaft, guide, CurveContact(cam, valve, disc, at=(0, height, 0), pin=(0, 0, 1))])
    angle = np.linspace(0.0, -16.0, 4001)
    lift = off * np.sin(angle) + np.sqrt(R * R - (off * np.cos(angle)) ** 2)
    around = np.unwrap(np.arctan2(lift - off * np.sin(angle), -off * np.cos(angle))) - angle
    found = accelerations(system, system.assemble(angles={shaft: -16.0}))
    assert found.slide("CurveContact 1")[0] == pytest.approx(R * (around[-1] - around[0]), abs=1e-9)  # of a spline
    assert found.slide(guide)[0] == pytest.approx(lift[-1] - height, abs=1e-9)


def crank_slider(crank):
    tip = 0.1 * np.array([np.cos(crank), np.sin(crank), 0.0])
    end = np.array([tip[0] + np.sqrt(0.09 - tip[1] ** 2), 0.0, 0.0])
    wheel, rod, piston = (
        Body(x, 1.0, (0.01, 0.02, 0.03), position=p) for x, p in zip("wrp", (tip, end, end), strict=True)
    )
    return System([wheel, rod, piston], [
        Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="crank"),
        Revolute(wheel, rod, at=tip, axis=(0, 0, 1), name="big end"), Revolute(rod, piston, at=end, axis=(0, 0, 1)),
        Prismatic(GROUND, piston, at=end, axis=(1, 0, 0), name="rail"),
    ])  # fmt: skip


def test_over_dead_centres_a_crank_goes_on():
    system = crank_slider(0.0)
    state = system.assemble(angles={"crank": 25.0})
    rod = -25.0 - np.arcsin(0.1 * np.sin(25.0) / 0.3)
    assert turned(system, state, "big end")[0] == pytest.approx(rod, abs=1e-12)
    assert state.notes == ()


def test_from_a_dead_centre_a_piston_leaves_the_side_to_chance_and_says_so():
    state = crank_slider(0.0).assemble(slides={"rail": -0.05})
    assert "ends after 0 % of the way" in state.notes[0]


def test_a_way_that_is_blocked_is_an_error_where_turns_depend_on_it():
    """Two long cranks cannot turn against each other: what lies behind is reached in steps, or not at all."""
    place, (crank, rod, apart), start = Place(16), (0.4, 0.35, 0.3), (1.9, 1.2)
    tips = [np.array([x + crank * np.cos(t), crank * np.sin(t)]) for x, t in zip((0, apart), start, strict=True)]
    gap = tips[1] - tips[0]
    height = np.sqrt(rod**2 - gap @ gap / 4.0) / np.linalg.norm(gap)
    top = (tips[0] + tips[1]) / 2.0 + height * np.array([-gap[1], gap[0]])
    ends = [(0.0, 0.0), tips[0], top, tips[1], (apart, 0.0)]
    bodies = [place.body(f"bar {k}", *ends[k], 0) for k in range(4)]
    chain = [GROUND, *bodies, GROUND]
    hinges = [
        Revolute(chain[k], chain[k + 1], at=place.at(*ends[k], 0), axis=place.to(0, 0, 1), name=f"h{k}")
        for k in range(5)
    ]
    system = place.mixed(bodies, hinges)
    with pytest.raises(AssemblyError, match="ends after 2.89 % of the way, which leaves open how often"):
        system.assemble(angles={"h0": 6.0, "h4": 6.0})


def test_from_a_flat_parallelogram_two_motions_lead_on_and_one_is_named():
    system, _ = parallelogram(Place(13), 0.0)
    assert "singular pose, where motions part" in system.assemble(angles={"crank": 4.0}).notes[0]


def test_other_hinges_of_a_chain_rest():
    """Also from a known state, many turns away; also a chain that floats."""
    rest = 1e-11  # rad, a hundred times the rounding of 47 rad and of places some lengths off: 1e-12 on one processor
    place, bodies, joints = Place(14), [], []
    for k in range(4):
        before = bodies[-1] if k else GROUND
        bodies.append(place.body(f"link {k}", 0.4 * k, 0, 0, mass=1.0 + k))
        joints.append(Revolute(before, bodies[-1], at=place.at(0.4 * k, 0, 0), axis=place.to(1, k, 2), name=f"h{k}"))
    names = [joint.name for joint in joints]
    system = place.mixed(bodies, joints)
    first = system.assemble(angles={"h1": 47.0})
    assert turned(system, first, *names) == pytest.approx([0, 47.0, 0, 0], abs=rest)
    second = system.assemble(angles={"h2": -8.0}, near=first)
    assert turned(system, second, *names) == pytest.approx([0, 47.0, -8.0, 0], abs=rest)
    assert not first.notes and not second.notes
    floating = place.mixed(bodies, joints[1:])
    state = floating.assemble(angles={"h2": 9.0})
    assert turned(floating, state, *names[1:]) == pytest.approx([0, 9.0, 0], abs=rest)


def test_a_helical_gear_that_may_slide_turns_unless_it_is_asked_to_slide():
    """A right-handed pinion at rest makes a wheel that slides by s turn by -s tan(beta) / r_b."""
    place, helix, r_a, r_b = Place(15), 0.4, 0.1, 0.25
    pinion, wheel = place.body("pinion", 0, 0, 0), place.body("wheel", r_a + r_b, 0, 0)
    z = place.to(0, 0, 1)
    fast = Revolute(GROUND, pinion, at=place.at(0, 0, 0), axis=z, name="fast")
    ends = {"at": place.at(r_a + r_b, 0, 0), "at_b": place.at(r_a + r_b, 0, -0.07)}  # its slide is -0.07 as drawn
    slow = Cylindrical(GROUND, wheel, **ends, axis=z, name="slow")
    mesh = GearMesh(fast, slow, at=place.at(r_a, 0, 0), helix_angle=helix)
    system = place.mixed([pinion, wheel], [fast, slow, mesh])
    for slide in (-0.07, 3.0):
        asked = {} if slide < 0.0 else {"slides": {"slow": slide}}
        state = system.assemble(angles={"fast": 20.0}, **asked)
        found = accelerations(system, state)
        assert found.slide("slow")[0] == pytest.approx(slide, abs=1e-12)
        turn = -20.0 * r_a / r_b - slide * np.tan(helix) / r_b
        assert found.angle("slow")[0] == pytest.approx(turn, abs=1e-10)
        assert state.notes == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_trains_over_many_turns(seed):
    """Spindles, planetary gears, parallelograms and four-bars of any ratio, size and place, from either end."""
    random = np.random.default_rng(1000 + seed)
    size, far = random.choice([1e-3, 1.0, 30.0]), random.choice([0.0, 100.0])
    angle, pitch = random.uniform(-80.0, 80.0), random.choice([-1, 1]) * random.uniform(0.002, 0.05)
    place = Place(seed, size, far * size)
    screw = spindle(place, pitch)
    way = -angle * pitch / TURNS * size
    assert turned(screw, screw.assemble(angles={"thread": -angle}), "rail")[0] == pytest.approx(way, rel=1e-7)
    assert turned(screw, screw.assemble(slides={"rail": way}), "hinge")[0] == pytest.approx(angle, rel=1e-5)

    teeth = random.integers(11, 60, 2)
    z_sun, z_ring, ring = teeth[0], teeth[0] + 2 * teeth[1], random.uniform(-30.0, 30.0)
    gears = planetary(Place(seed), teeth, random.uniform(1e-3, 2e-2), random.uniform(-0.5, 0.5))
    carrier = (z_sun * angle + z_ring * ring) / (z_sun + z_ring)
    state = gears.assemble(angles={"carrier": carrier, "ring": ring})
    assert turned(gears, state, "sun")[0] == pytest.approx(angle, rel=1e-10, abs=1e-10)

    bars, _ = parallelogram(Place(seed, size, far * size), random.uniform(0.3, 2.8))
    limit = 1e-8 * max(1.0, far)
    assert turned(bars, bars.assemble(angles={"eye": angle}), "crank", "pin", "motor") == pytest.approx(
        [angle, -angle, -angle / 0.31], rel=limit
    )
    short, others = 0.1, random.uniform(0.3, 0.4, 3)  # Grashof: the shortest and the longest less than the others
    linkage, after = four_bar(Place(seed), short, *others, random.uniform(0.3, 2.5))
    state = linkage.assemble(angles={"crank": angle})
    assert turned(linkage, state, "pin", "eye", "rocker") == pytest.approx(after(angle), abs=1e-8)
