"""Statements of the data file on published against true physics, each checked with computed figures."""

from dataclasses import replace

import numpy as np

from engines.balance import phasor, planar_sum
from engines.balance.layouts import Engine, data
from engines.balance.published.claims import (
    Row,
    actual,
    assumed,
    below,
    couple,
    ellipse,
    family,
    force,
    frames,
    peaks,
    per_spacing,
    relative,
    ripple,
)

Figure = tuple[str, str, float | None, float | None, float | None, str]
"""What, unit, published, assumed, actual, verdict."""
Figures = dict[str, list[Figure]]  # by the layouts they are about: beginnings of names, as `family` takes them


def corrections() -> list[Row]:
    """Return rows for every entry of published_vs_true_physics, in its order."""
    parts: tuple[Figures, ...] = (
        *(centre_of_mass(), sanity(), {"I4": sweep()}, boxer(), {"flat4": flat()}, {"I3": three()}, {"I5": five()}),
        *(six(), {"V6_60": v6_60()}, {"V6_90": v6_90()}, {"V8_flat": v8_flat()}, {"V8_cross": v8_cross()}),
        *({"V10": v10()}, {"V8_cross": rotating()}, {"single": odd()}),
    )
    return [
        Row(entry["layout"], *figure, layouts=family(about))
        for entry, part in zip(data()["published_vs_true_physics"], parts, strict=True)
        for about, figures in part.items()
        for figure in figures
    ]


def centre_of_mass() -> Figures:
    """Return rows on the force m_c w^2 r_c of the crank."""
    wrong, beside = "holds for a crank with its centre of mass on the axis", "omitted by the source"

    def pair(name: str, what: str, published: float) -> list[Figure]:
        pitch, true_pitch = (couple(h(name), 1) for h in (assumed, actual))
        across, true_across = (couple(h(name), 1, 0) for h in (assumed, actual))
        return [
            (f"1x pitch couple, {what}", "N m", published, pitch, true_pitch, wrong),
            (f"1x couple across, {what}", "N m", None, across, true_across, beside),
        ]

    one, true_one = (force(h("single"), 1) for h in (assumed, actual))
    single = ("1x along the bore, one cylinder", "N", 9.87, one, true_one, wrong)
    flat4, three = pair("flat4_shared_face_to_face", "flat 4", 3.95), pair("I3", "I3", 1.71)
    return {"single": [single], "flat4": flat4, "I3": three}


def sanity() -> Figures:
    """Return rows on F_2x = 4 F_single R / L of the inline four."""
    engine, four = Engine("I4"), force(actual("I4"), 2)
    lam, single = engine.radius / engine.rod_length, force(assumed("single"), 1)
    leading = 4 * phasor.reciprocating(engine) * engine.rate**2 * engine.radius * lam
    one: list[Figure] = [
        ("F_single = F_2x / (4 R / L)", "N", 8.22, four / (4 * lam), single, "1x moves 9 kg, 2x only 7 kg"),
        ("2x of one cylinder", "N", None, None, force(actual("single"), 2), "a quarter of the four's"),
    ]
    all_four: list[Figure] = [
        ("2x to leading order", "N", None, leading, four, "the series has more terms"),
        ("2x over leading order", "-", 1.0, None, four / leading, "7.1 % more"),
    ]
    return {"I4 single": one, "I4": all_four}


def sweep() -> list[Figure]:
    """Return rows on 2x of the inline four over R / L."""
    found: list[Figure] = []
    for length in (4.0, 3.0, 2.0, 1.5):
        engine = Engine("I4", rod_length=length)
        leading = 4 * phasor.reciprocating(engine) * engine.rate**2 * engine.radius**2 / length
        ratio = force(actual("I4", length), 2) / leading
        found.append((f"2x over leading order, R/L = {1 / length:.4g}", "-", 1.0, None, ratio, "grows faster than R/L"))
    return found


def boxer() -> Figures:
    """Return rows on opposed pistons, which cannot share a station."""
    ideal, real = "boxer4_face_to_face", "boxer4"
    four = ("2x driving torque, inline four", "N m", None, None, ripple("I4", 2), "the same")
    two: list[Figure] = [
        ("1x couple", "N m", 0.0, ellipse(assumed(ideal), 1)[0], ellipse(actual(real), 1)[0], "agrees"),
        ("2x yaw couple, staggered by 0.1 m", "N m", 0.0, couple(assumed(ideal), 2), couple(actual(real), 2), "2 s F2"),
        ("2x driving torque", "N m", 0.0, None, ripple(real, 2), "not still: as much as an inline four"),
    ]
    return {"boxer4": two, "boxer4 I4": [four]}


def flat() -> list[Figure]:
    """Return rows on the flat four that is not a boxer."""
    ideal, real = "flat4_shared_face_to_face", "flat4_shared"
    a = couple(assumed(ideal), 1) / couple(assumed("I3"), 1)
    return [
        ("1x couple", "N m", 3.95, couple(assumed(real), 1), couple(actual(real), 1), "4 s F1 of the assumed force"),
        ("2x couple", "N m", 0.0, couple(assumed(ideal), 2), couple(actual(real), 2), "2 s F2 where staggered"),
        ("over inline three, per bore spacing", "-", 2.3, a, None, "staggered"),
        ("over inline three, per distance of pairs", "-", 2.3, a / 2, None, "pair distance 2 a against spacing a"),
    ]


def three() -> list[Figure]:
    """Return rows on the inline three."""
    one, two = (per_spacing("I3", n, couple(assumed("I3"), n)) for n in (1, 2))
    return [
        ("1x couple over F1 a", "-", None, one, None, "square root of 3"),
        ("2x couple over F2 a", "-", None, two, None, "square root of 3"),
        ("6x force", "N", None, force(assumed("I3"), 6), force(actual("I3"), 6), "3 F6"),
        ("3x driving torque", "N m", None, None, ripple("I3", 3), "inertia torque"),
    ]


def five() -> list[Figure]:
    """Return rows on the inline five."""
    real, sequential = "I5", "I5_sequential"
    seen = frames(real)[1].max()
    wrong = "peak of both harmonics, most of it 2x"
    found: list[Figure] = [
        ("peak of the primary moment", "N m", 66.56, seen, None, wrong),
        ("of which 1x", "N m", None, peaks(real, (1,))[1], None, "a sixth"),
        ("of which 2x", "N m", None, peaks(real, (2,))[1], None, "the secondary couple is what this engine has"),
    ]
    for name, note in ((real, "firing order 1-2-4-5-3"), (sequential, "throws in sequence")):
        for order in (1, 2):
            value = per_spacing(name, order, couple(assumed(name), order))
            found.append((f"{order}x couple over F{order} a, {name}", "-", None, value, None, note))
    return found


def six() -> Figures:
    """Return rows on the inline six and the V12."""
    still, shaken, torque = "forces and couples 1x ... 5x", "not perfectly still", "inertia torque"
    inline: list[Figure] = [
        (f"{still}, I6", "N", 0.0, None, below("I6"), "agrees"),
        ("6x force, I6", "N", 0.0, None, force(actual("I6"), 6), shaken),
        ("3x driving torque, I6", "N m", None, None, ripple("I6", 3), torque),
    ]
    vee: list[Figure] = [
        (f"{still}, V12", "N", 0.0, None, below("V12_60"), "agrees"),
        ("6x force, V12", "N", 0.0, None, force(actual("V12_60"), 6, 1), shaken),
        ("6x driving torque, V12", "N m", None, None, ripple("V12_60", 6), torque),
    ]
    return {"I6": inline, "V12": vee}


def figures(name: str, order: int, kind: str, verdict: str) -> list[Figure]:
    """Return two rows of `relative`."""
    words = ("long half axis", "short half axis") if kind == "ellipse" else ("forward", "backward")
    values = relative(name, order, kind)
    return [
        (f"{order}x couple over F{order} a, {name}, {word}", "-", None, value, None, verdict)
        for word, value in zip(words, values, strict=True)
    ]


def v6_60() -> list[Figure]:
    """Return rows on the V6 of 60 degrees with three kinds of pins."""
    plus, minus, shared = "V6_60_offset+60", "V6_60_offset-60", "V6_60_shared"
    return [
        ("6x force", "N", None, None, force(actual(plus), 6, 1), "all lower orders are balanced"),
        *figures(plus, 1, "turning", "counterweights remove it"),
        *figures(plus, 2, "turning", "turns backward; omitted by the source"),
        *figures(minus, 1, "ellipse", "in a plane: a nod, needs a balance shaft"),
        *figures(shared, 1, "ellipse", "shared pins, not even-fire"),
    ]


def v6_90() -> list[Figure]:
    """Return rows on the V6 of 90 degrees."""
    return [
        *figures("V6_90_shared", 2, "ellipse", "in the horizontal plane"),
        *figures("V6_90_shared", 1, "turning", "counterweights remove it"),
        *figures("V6_90_split30", 1, "ellipse", "split pins"),
        *figures("V6_90_split30", 2, "ellipse", "split pins"),
    ]


def v8_flat() -> list[Figure]:
    """Return rows on the V8 with a flat crank."""
    name, root = "V8_flat", 4 * np.sqrt(2)
    two, four = (root * force(actual("single"), order) for order in (2, 4))
    return [
        ("2x horizontal force", "N", 23.26, two, force(actual(name), 2), "4 sqrt(2) F2, agrees"),
        ("2x vertical force", "N", None, None, force(actual(name), 2, 1), "not vertical, as one table says"),
        ("4x vertical force", "N", 1.67, four, force(actual(name), 4, 1), "4 sqrt(2) F4, agrees"),
        ("couples 1x, 2x", "N m", 0.0, None, max(ellipse(actual(name), n)[0] for n in (1, 2)), "agrees"),
    ]


def v8_cross() -> list[Figure]:
    """Return rows on the V8 with a crossed crank, as built and as published."""
    real, preset = "V8_cross", "V8_cross_in_sequence"
    least, most = (float(f(frames(preset)[1])) for f in (np.min, np.max))
    (one, true_one), (preset_one, true_preset_one) = (
        [ellipse(h(name), 1)[0] for h in (assumed, actual)] for name in (real, preset)
    )
    return [
        *figures(real, 1, "turning", "sqrt(10); the real crank"),
        ("1x couple, real crank", "N m", None, one, true_one, "of constant size"),
        ("2x couple, real crank", "N m", 0.0, ellipse(assumed(real), 2)[0], ellipse(actual(real), 2)[0], "agrees"),
        ("1x couple, preset", "N m", 2.79, preset_one, true_preset_one, "2 sqrt(2) F1 a"),
        ("2x pitch couple, preset", "N m", 0.0, couple(assumed(preset), 2), couple(actual(preset), 2), "not balanced"),
        ("least moment of the gif", "N m", 100.282, least, None, "not of constant size"),
        ("largest moment of the gif", "N m", 100.282, most, None, "agrees"),
        ("4x force", "N", None, None, force(actual(real), 4, 1), "not mentioned by the source"),
    ]


def v10() -> list[Figure]:
    """Return rows on the V10 of 72 degrees."""
    found = []
    for name, note in (("V10_72_steps_of_144", "throws of the source"), ("V10_72", "throws of the inline five")):
        for order in (1, 2):
            found += figures(name, order, "ellipse", note)
    return found


def rotating() -> list[Figure]:
    """Return rows on big ends and crank, which turn with the pin: projected on the bores they count half."""
    engine = Engine("V8_cross_in_sequence")
    on_axis = phasor.block_load(replace(engine, crank_centre=0.0))
    # counterweights as heavy as the big ends, 9 kg on the piston's side: then the projection is right
    balanced = phasor.block_load(replace(engine, crank_centre=-1.0, piston_mass=7.0))
    one, two = (couple(load, 1) for load in (on_axis, balanced))
    full = couple(actual("V8_cross_in_sequence"), 1)
    return [
        ("1x couple, crank's centre on the axis", "N m", 2.79, one, full, "the projection counts too little"),
        ("1x couple, masses with U = 0, m_rec = 9 kg", "N m", 2.79, two, two, "the projection holds for these"),
    ]


def odd() -> list[Figure]:
    """Return rows on odd harmonics from 3x on."""
    skew = float(np.abs(planar_sum.harmonics(Engine("single", offset=0.1)).force[3, 0]))
    return [
        ("3x force, centred", "N", 0.0, None, force(actual("single"), 3), "agrees"),
        ("3x force, bore offset by 0.1 m", "N", 0.0, None, skew, "only centred cylinders have none"),
        ("3x driving torque per cylinder", "N m", 0.0, None, ripple("single", 3), "not zero"),
    ]
