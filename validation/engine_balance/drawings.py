"""Drawings of engine balance as SVG whose colours are variables of the page they stand in: x right, y up, z to the reader.

    x + i y = forward exp(i n q) + conj(backward) exp(-i n q)      a harmonic, see `harmonics`
"""

from typing import Any

import numpy as np
from markupsafe import Markup, escape

from .layouts import Layout

RADIUS = 88.0  # of the largest circle, in a square from -110 to 110
WAYS = ("phasor", "planar", "spatial")


def svg(width: float, height: float, body: str, label: str, *, left: float = 0.0, top: float = 0.0) -> Markup:
    """An element with a text for those who do not see it."""
    box = f"{left:g} {top:g} {width:g} {height:g}"
    return Markup(f'<svg viewBox="{box}" role="img" aria-label="{escape(label)}">{body}</svg>')


def at(z: complex) -> str:
    """Coordinates of a point, y up."""
    return f"{z.real:.2f} {-z.imag + 0.0:.2f}"


def arrow(start: complex, end: complex, tint: str) -> str:
    """A line with a head; none where there is no room for one."""
    length = abs(end - start)
    if length < 2.0:
        return ""
    along = (end - start) / length
    back, half = min(9.0, 0.6 * length), min(3.6, 0.24 * length)
    neck = end - back * along
    head = f"M{at(end)}L{at(neck + 1j * half * along)}L{at(neck - 1j * half * along)}Z"
    return f'<path class="line {tint}" d="M{at(start)}L{at(neck)}"/><path class="fill {tint}" d="{head}"/>'


def cross() -> str:
    """The axes of a square drawing."""
    lines = f'<path class="axis" d="M-104 0H104M0 104V-104"/><circle class="axis" r="{RADIUS:g}"/>'
    return lines + '<text class="small" x="106" y="-4" text-anchor="end">x</text><text class="small" x="4" y="-98">y</text>'


def polar(forward: complex, backward: complex, label: str) -> Markup:
    """A harmonic: the vector that turns with the crank, the one that turns against it, and the ellipse of their sum.

    Parameters
    ----------
    forward, backward : complex
        Phasors; the arrows stand at q = 0. Drawn to a scale of its own.
    label : str
    """
    scale = RADIUS / (abs(forward) + abs(backward))
    f, b = scale * complex(forward), scale * complex(backward).conjugate()
    body = cross() + circle(f, 1, "t0") + circle(b, -1, "t1") + ellipse(forward, backward, RADIUS)
    if min(abs(f), abs(b)) > 1.0:
        body += f'<path class="construct" d="M{at(f)}L{at(f + b)}L{at(b)}"/>'
    return svg(220, 220, body + arrow(0, f, "t0") + arrow(0, b, "t1") + dot(f + b), label, left=-110, top=-110)


def dot(z: complex) -> str:
    """Where the tip is at q = 0."""
    return f'<circle class="fill ink" cx="{z.real:.2f}" cy="{-z.imag + 0.0:.2f}" r="3.4"/>'


def circle(z: complex, sense: int, tint: str) -> str:
    """The circle on which the tip of z runs, with a head that says which way."""
    radius = abs(z)
    if radius < 1.0:
        return ""
    ring = f'<circle class="ring {tint}" r="{radius:.2f}"/>'
    if radius < 14.0:
        return ring
    place = z * np.exp(0.7j * sense)
    along = 1j * sense * place / radius
    tip, side = place + 5 * along, 3.2 * place / radius
    return ring + f'<path class="fill {tint}" d="M{at(tip)}L{at(place - 3 * along + side)}L{at(place - 3 * along - side)}Z"/>'


def ellipse(forward: complex, backward: complex, size: float, tint: str = "ink") -> str:
    """What the tip draws: half axes |f| + |b| and ||f| - |b||, the long one along (arg f - arg b) / 2."""
    f, b = abs(forward), abs(backward)
    turn = np.degrees(np.angle(forward) - np.angle(backward)) / 2 if min(f, b) > 0 else 0.0
    short = size * abs(f - b) / (f + b)
    return f'<ellipse class="path {tint}" rx="{size:.2f}" ry="{short:.2f}" transform="rotate({-turn:.2f})"/>'


def icon(forward: complex, backward: complex) -> Markup:
    """The ellipse of a harmonic, small; its colour tells which way it turns."""
    tint = "t0" if abs(forward) > abs(backward) * 1.001 else "t1" if abs(backward) > abs(forward) * 1.001 else "ink"
    return Markup(f'<svg class="icon" viewBox="-10 -10 20 20" aria-hidden="true">{ellipse(forward, backward, 8.0, tint)}</svg>')


def still(label: str) -> Markup:
    """A harmonic that is not there."""
    return svg(220, 220, cross() + '<text class="nil" y="-8" text-anchor="middle">0</text>', label, left=-110, top=-110)


def loop(x: np.ndarray, y: np.ndarray, label: str) -> Markup:
    """The path of all harmonics together over a turn, (k,) each; the dot is at q = 0."""
    z = (x + 1j * y) * (RADIUS / np.hypot(x, y).max())
    path = "M" + "L".join(at(p) for p in z) + "Z"
    return svg(220, 220, cross() + f'<path class="path ink" d="{path}"/>' + dot(z[0]), label, left=-110, top=-110)


def star(layout: Layout, *, numbers: bool = True) -> Markup:
    """The crank seen against z: its pins, and the bores around it with the numbers of their cylinders."""
    pins, bores = {}, {}
    for i, (pin, bore) in enumerate(zip(layout.pins, layout.bores, strict=True), start=1):
        pins.setdefault(round(pin % 360.0, 6), []).append(i)
        bores.setdefault(round(bore % 360.0, 6), []).append(i)
    body = '<circle class="axis" r="46"/><circle class="fill muted" r="4"/>'
    for angle, which in bores.items():
        u = np.exp(1j * np.radians(angle))
        v = 1j * u
        body += f'<path class="bore" d="M{at(58 * u + 13 * v)}L{at(92 * u + 13 * v)}M{at(58 * u - 13 * v)}L{at(92 * u - 13 * v)}"/>'
        body += f'<path class="fill t4" d="M{at(66 * u + 11 * v)}L{at(82 * u + 11 * v)}L{at(82 * u - 11 * v)}L{at(66 * u - 11 * v)}Z"/>'
        body += f'<path class="axis" d="M{at(46 * u)}L{at(100 * u)}"/>'
    for angle, which in pins.items():
        u = np.exp(1j * np.radians(angle))
        body += f'<path class="throw" d="M0 0L{at(46 * u)}"/><circle class="fill t1" cx="{46 * u.real:.2f}" cy="{-46 * u.imag + 0.0:.2f}" r="6.5"/>'
        if numbers:
            p = 29 * u + 9j * u
            text = " ".join(map(str, which))
            body += f'<text class="number" x="{p.real:.2f}" y="{-p.imag + 3.5:.2f}" text-anchor="middle">{text}</text>'
    return svg(220, 220, body, f"crank and bores of {layout.name}", left=-110, top=-110)


def plan(layout: Layout, stations: np.ndarray) -> Markup:
    """Where along the crank the cylinders stand: stations to the right, one line per direction of bores."""
    rows = list(dict.fromkeys(layout.bores))
    span = max(float(np.ptp(stations)), 1e-12)
    body = ""
    for k, bore in enumerate(rows):
        y = 24 + 30 * k
        body += f'<path class="axis" d="M52 {y}H312"/><text class="small" x="44" y="{y + 4}" text-anchor="end">{bore:g}\u00b0</text>'
    for i, (z, bore) in enumerate(zip(stations, layout.bores, strict=True), start=1):
        x = 182.0 if np.ptp(stations) == 0 else 66 + 232 * (z - stations.min()) / span
        y = 24 + 30 * rows.index(bore)
        body += f'<circle class="fill t4" cx="{x:.2f}" cy="{y}" r="11"/><text class="on" x="{x:.2f}" y="{y + 4}" text-anchor="middle">{i}</text>'
    y = 24 + 30 * len(rows)
    for z in sorted(set(np.round(stations, 12).tolist())):
        x = 182.0 if np.ptp(stations) == 0 else 66 + 232 * (z - stations.min()) / span
        body += f'<text class="small" x="{x:.2f}" y="{y}" text-anchor="middle">{z:.3g}</text>'
    body += f'<text class="small" x="44" y="{y}" text-anchor="end">z [m]</text>'
    return svg(330, y + 8, body, "stations along the crank")


def bars(values: dict[str, np.ndarray], texts: list[str], label: str) -> Markup:
    """Amplitudes (orders,) of every way beside each other, by order from 1 on; ``texts`` stand above them."""
    top = max(float(np.max(v)) for v in values.values()) or 1.0
    body = '<path class="frame" d="M6 132H334"/>'
    for k, text in enumerate(texts):
        middle, highest = 34 + 54.5 * k, 0.0
        for j, way in enumerate(values):
            height = 108 * float(values[way][k]) / top
            height = 0.0 if height < 0.05 else max(height, 0.7)
            highest = max(highest, height)
            if height:
                body += f'<rect class="fill t{j}" x="{middle - 20 + 13.5 * j:.2f}" y="{132 - height:.2f}" width="12.5" height="{height:.2f}"/>'
        body += f'<text class="value" x="{middle:g}" y="{128 - highest:.2f}" text-anchor="middle">{text}</text>'
        body += f'<text class="small" x="{middle:g}" y="146" text-anchor="middle">{k + 1}x</text>'
    return svg(340, 152, body, label)


def ticks(low: float, high: float, count: int = 5) -> np.ndarray:
    """Round numbers between low and high."""
    step = 10.0 ** np.floor(np.log10((high - low) / count))
    step *= next(f for f in (1.0, 2.0, 5.0, 10.0) if (high - low) / (step * f) <= count)
    return np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step


def curve(angle: np.ndarray, values: np.ndarray, dots: tuple[np.ndarray, np.ndarray], label: str, unit: str) -> Markup:
    """A closed form over the crank angle [degrees] as a line, samples of another way as dots."""
    size = max(float(np.abs(values).max()), 1e-12)
    low, high = min(float(values.min()), 0.0) - 0.06 * size, max(float(values.max()), 0.0) + 0.06 * size

    def place(q: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        return 56 + 650 * np.asarray(q) / 360.0, 196 - 180 * (np.asarray(y) - low) / (high - low)

    body = ""
    for y in ticks(low, high):
        level = float(place(0, y)[1])
        body += f'<path class="grid" d="M56 {level:.2f}H706"/><text class="small" x="50" y="{level + 4:.2f}" text-anchor="end">{y + 0.0:g}</text>'
    for q in range(0, 361, 45):
        x = float(place(q, 0)[0])
        body += f'<path class="grid" d="M{x:.2f} 16V196"/><text class="small" x="{x:.2f}" y="212" text-anchor="middle">{q}\u00b0</text>'
    body += f'<path class="frame" d="M56 {float(place(0, 0)[1]):.2f}H706"/><text class="small" x="6" y="10">{escape(unit)}</text>'
    body += '<path class="line t0" d="M' + "L".join(f"{x:.2f} {y:.2f}" for x, y in zip(*place(angle, values), strict=True)) + '"/>'
    body += "".join(f'<circle class="sample" cx="{x:.2f}" cy="{y:.2f}" r="3"/>' for x, y in zip(*place(*dots), strict=True))
    return svg(716, 218, body, label)
