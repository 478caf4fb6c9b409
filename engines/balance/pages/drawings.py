"""Drawings of engine balance as SVG; their colours are variables of the page. x to the right, y up, z to the reader.

    x + i y = forward exp(i n q) + conj(backward) exp(-i n q)      a harmonic, see `harmonics`

Points are complex numbers x + i y.
"""

from typing import Any

import numpy as np
from markupsafe import Markup, escape

from engines.balance.layouts import Layout

LARGEST_CIRCLE_RADIUS = 88.0  # [drawing units] of the largest circle, in a square from -110 to 110
VISIBLE_RADIUS_MIN = 1.0  # [drawing units] radius of a circle that can be seen


def svg(width: float, height: float, body: str, label: str, corner: str = "0 0") -> Markup:
    """Return an SVG element with an alternative text."""
    return Markup(f'<svg viewBox="{corner} {width:g} {height:g}" role="img" aria-label="{escape(label)}">{body}</svg>')


def square(body: str, label: str) -> Markup:
    """Return a square SVG drawing about the origin."""
    return svg(220, 220, body, label, "-110 -110")


def at(z: complex) -> str:
    """Return the coordinates of a point as SVG text."""
    return f"{z.real + 0.0:.2f} {-z.imag + 0.0:.2f}"


def stroke(kind: str, *points: complex) -> str:
    """Draw an open line through points."""
    return f'<path class="{kind}" d="M{"L".join(map(at, points))}"/>'


def area(tint: str, *corners: complex) -> str:
    """Draw a filled polygon."""
    return f'<path class="fill {tint}" d="M{"L".join(map(at, corners))}Z"/>'


def dot(z: complex, tint: str = "ink", radius: float = 3.4) -> str:
    """Draw a filled circle; in ink, it marks the tip of a vector at q = 0."""
    return f'<circle class="fill {tint}" cx="{z.real + 0.0:.2f}" cy="{-z.imag + 0.0:.2f}" r="{radius:g}"/>'


def text(x: float, y: float, words: str, anchor: str = "middle", kind: str = "small") -> str:
    """Draw a text; y counts downwards, to its foot."""
    return f'<text class="{kind}" x="{x + 0.0:.2f}" y="{y + 0.0:.2f}" text-anchor="{anchor}">{escape(words)}</text>'


def signed(x: float, digits: int = 6) -> str:
    """Format a number with a true minus sign."""
    return f"{x + 0.0:.{digits}g}".replace("-", "\u2212")


def arrow(start: complex, end: complex, tint: str) -> str:
    """Draw a line with an arrow head, or nothing where there is no room for one."""
    length = abs(end - start)
    if length < 2.0:
        return ""
    along = (end - start) / length
    neck, half = end - min(9.0, 0.6 * length) * along, min(3.6, 0.24 * length)
    return stroke(f"line {tint}", start, neck) + area(tint, end, neck + 1j * half * along, neck - 1j * half * along)


def axes() -> str:
    """Draw the axes of a square drawing, with the circle of the largest amplitude."""
    lines = f'<path class="axis" d="M-104 0H104M0 104V-104"/><circle class="axis" r="{LARGEST_CIRCLE_RADIUS:g}"/>'
    return lines + text(106, -4, "x", "end") + text(4, -98, "y", "start")


def polar(forward: complex, backward: complex, label: str) -> Markup:
    """Draw a harmonic: the vectors that turn with and against the crank, and the ellipse of their sum.

    ``forward, backward``: phasors, not both 0; the arrows are those at q = 0. Each has its own scale.
    """
    scale = LARGEST_CIRCLE_RADIUS / (abs(forward) + abs(backward))
    f, b = scale * complex(forward), scale * complex(backward).conjugate()
    body = axes() + ring(f, 1, "t0") + ring(b, -1, "t1") + ellipse(forward, backward, LARGEST_CIRCLE_RADIUS)
    aside: complex = 0.0
    if min(abs(f), abs(b)) > VISIBLE_RADIUS_MIN:
        body += stroke("construct", f, f + b, b)
        if abs(np.angle(b / f)) < 0.1:  # one would lie upon the other
            aside = 3j * f / abs(f)
    return square(body + arrow(aside, f + aside, "t0") + arrow(-aside, b - aside, "t1") + dot(f + b), label)


def ring(z: complex, sense: int, tint: str) -> str:
    """Draw the circle of the tip of z, with a head for its sense of rotation (+1: from x to y)."""
    radius = abs(z)
    if radius < VISIBLE_RADIUS_MIN:
        return ""
    circle = f'<circle class="ring {tint}" r="{radius:.2f}"/>'
    if radius < 14.0:
        return circle
    place = z * np.exp(0.7j * sense)
    along, side = 1j * sense * place / radius, 3.2 * place / radius
    return circle + area(tint, place + 5 * along, place - 3 * along + side, place - 3 * along - side)


def ellipse(forward: complex, backward: complex, size: float, tint: str = "ink") -> str:
    """Draw the ellipse of the tip: half axes |f| + |b| and ||f| - |b||, the long one along (arg f - arg b) / 2."""
    f, b = abs(forward), abs(backward)
    angle = (np.angle(forward) - np.angle(backward)) / 2 if min(f, b) > 0 else 0.0
    short, end = size * abs(f - b) / (f + b), size * np.exp(1j * angle)
    if short < 0.02:
        return stroke(f"path {tint}", -end, end)
    turn = signed(-np.degrees(angle)).replace("\u2212", "-")
    return f'<ellipse class="path {tint}" rx="{size:g}" ry="{short:.2f}" transform="rotate({turn})"/>'


def icon(forward: complex, backward: complex) -> Markup:
    """Draw a small ellipse of a harmonic; its colour shows the sense of rotation."""
    f, b = abs(forward), abs(backward)
    tint = "t0" if f > 1.001 * b else "t1" if b > 1.001 * f else "ink"
    body = ellipse(forward, backward, 8.0, tint)
    return Markup(f'<svg class="icon" viewBox="-10 -10 20 20" aria-hidden="true">{body}</svg>')


def still(label: str) -> Markup:
    """Draw the placeholder of a harmonic that vanishes."""
    return square(axes() + text(0, -8, "0", kind="nil"), label)


def loop(x: np.ndarray, y: np.ndarray, label: str) -> Markup:
    """Draw the closed path of all orders together over a turn, x and y (k,) each; the dot is at q = 0."""
    z = (x + 1j * y) * (LARGEST_CIRCLE_RADIUS / np.hypot(x, y).max())
    return square(axes() + stroke("path ink", *z, z[0]) + dot(z[0]), label)


def star(layout: Layout, *, numbers: bool = True) -> Markup:
    """Draw the crank seen against z: pins with the numbers of their cylinders, and the bores around."""
    pins: dict[float, list[str]] = {}
    for i, pin in enumerate(layout.pins, start=1):
        pins.setdefault(round(pin % 360.0, 6), []).append(str(i))
    body = f'<circle class="axis" r="46"/>{dot(0j, "muted", 4)}'
    for bore in dict.fromkeys(layout.bores):
        u = np.exp(1j * np.radians(bore))
        body += stroke("bore", (58 + 13j) * u, (92 + 13j) * u) + stroke("bore", (58 - 13j) * u, (92 - 13j) * u)
        body += area("t4", (66 + 11j) * u, (82 + 11j) * u, (82 - 11j) * u, (66 - 11j) * u) + stroke(
            "axis", 46 * u, 100 * u
        )
    for pin, cylinders in pins.items():
        u = np.exp(1j * np.radians(pin))
        body += stroke("throw", 0j, 46 * u) + dot(46 * u, "t1", 6.5 if numbers else 13)
        if numbers:
            words = " ".join(cylinders)
            aside = 5 + 3.3 * len(words) * abs(u.imag) + 5 * abs(u.real)  # half the text, seen across the throw
            place = (27 + 1j * aside) * u
            body += text(place.real, 3.5 - place.imag, words, kind="number")
    return square(body, f"crank and bores of {layout.name}")


def plan(layout: Layout, stations: np.ndarray) -> Markup:
    """Draw the stations of the cylinders (n,) [m] along the crank, one line per direction of bores."""
    span, lines = float(np.ptp(stations)), list(dict.fromkeys(layout.bores))
    across = 66 + 232 * (stations - stations.min()) / span if span else np.full(stations.size, 182.0)
    body, foot = "", 24 + 30 * len(lines)
    for k, bore in enumerate(lines):
        y = 24 + 30 * k
        body += f'<path class="axis" d="M52 {y}H312"/>' + text(44, y + 4, f"{bore:g}\u00b0", "end")
    for i, (x, bore) in enumerate(zip(across, layout.bores, strict=True), start=1):
        y = 24 + 30 * lines.index(bore)
        body += dot(complex(x, -y), "t4", 11) + text(x, y + 4, str(i), kind="on")
    for x, z in dict(zip(np.round(across, 3), stations, strict=True)).items():
        body += text(x, foot, signed(round(z, 9), 3))
    return svg(330, foot + 8, body + text(44, foot, "z [m]", "end"), "stations along the crank")


def bars(values: dict[str, np.ndarray], texts: list[str], label: str) -> Markup:
    """Draw the amplitudes (orders,) of every method side by side, by order from 1 on, with ``texts`` above them."""
    top = max(float(np.max(amplitudes)) for amplitudes in values.values()) or 1.0
    body = '<path class="frame" d="M6 132H334"/>'
    for k, words in enumerate(texts):
        middle, heights = 34 + 54.5 * k, [108 * float(amplitudes[k]) / top for amplitudes in values.values()]
        for j, height in enumerate(heights):
            if height > 0.05:
                place = f'x="{middle - 20 + 13.5 * j:.2f}" y="{132 - max(height, 0.7):.2f}"'
                body += f'<rect class="fill t{j}" {place} width="12.5" height="{max(height, 0.7):.2f}"/>'
        body += text(middle, 128 - max(heights), words, kind="value") + text(middle, 146, f"{k + 1}x")
    return svg(340, 152, body, label)


def ticks(low: float, high: float, count: int = 5) -> np.ndarray:
    """Return at most count + 1 round numbers between low and high."""
    step = 10.0 ** np.floor(np.log10((high - low) / count))
    step *= next(f for f in (1.0, 2.0, 5.0, 10.0) if (high - low) / (step * f) <= count)
    return np.round(np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step, 12)


def curve(angle: np.ndarray, values: np.ndarray, dots: tuple[np.ndarray, np.ndarray], label: str, unit: str) -> Markup:
    """Draw values over the crank angle [degrees] of whole turns as a line, and samples (angle, value) of another method
    as dots.
    """
    end = round(float(angle[-1]))
    size = max(float(np.abs(values).max()), 1e-12)
    low, high = min(float(values.min()), 0.0) - 0.06 * size, max(float(values.max()), 0.0) + 0.06 * size

    def place(q: Any, y: Any) -> np.ndarray:
        return 44 + 940 * np.asarray(q) / end - 1j * (208 - 190 * (np.asarray(y) - low) / (high - low))

    body = ""
    for y in ticks(low, high):
        body += stroke("grid", complex(place(0, y)), complex(place(end, y)))
        body += text(38, 4 - complex(place(0, y)).imag, signed(y), "end")
    for q in range(0, end + 1, end // 12):
        body += stroke("grid", complex(place(q, low)), complex(place(q, high))) + text(
            44 + 940 * q / end, 224, f"{q}\u00b0"
        )
    body += stroke("frame", complex(place(0, 0)), complex(place(end, 0))) + text(6, 10, unit, "start")
    body += stroke("line t0", *place(angle, values))
    for z in place(*dots):
        body += f'<circle class="sample" cx="{z.real:.2f}" cy="{-z.imag:.2f}" r="3"/>'
    return svg(1000, 230, body, label)
