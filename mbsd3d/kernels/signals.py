"""Value, first and second derivative of a signal at time t; a signal is a sum of terms."""

import numpy as np

from ..compiler.decorators import kernel
from .kinds import POLYNOMIAL, SINE


@kernel
def polynomial(data, first, count, x):
    """Return c0 + c1 x + ... and its two derivatives, by Horner's rule."""
    f, g, h = 0.0, 0.0, 0.0
    for k in range(count - 1, -1, -1):
        h = h * x + 2.0 * g
        g = g * x + f
        f = f * x + data[first + k]
    return f, g, h


@kernel
def spline(data, first, x):
    """Return a piecewise cubic and two derivatives: [pieces, breaks, 4 coefficients a piece, highest power first]."""
    pieces = int(data[first].real)
    breaks = first + 1
    low, high = 0, pieces - 1
    while low < high:
        middle = (low + high + 1) // 2
        if data[breaks + middle].real <= x:
            low = middle
        else:
            high = middle - 1
    c = breaks + pieces + 1 + 4 * low
    s = x - data[breaks + low]
    c3, c2, c1, c0 = data[c], data[c + 1], data[c + 2], data[c + 3]
    return ((c3 * s + c2) * s + c1) * s + c0, (3.0 * c3 * s + 2.0 * c2) * s + c1, 6.0 * c3 * s + 2.0 * c2


@kernel
def signal(m, i, t):
    """Return (f, f', f'') of signal i at time t."""
    f, g, h = 0.0, 0.0, 0.0
    for k in range(m.signal[i].first, m.signal[i].end):
        term = m.term[k]
        first = term.first
        if term.kind == POLYNOMIAL:
            df, dg, dh = polynomial(m.term_data, first, term.end - first, t)
        elif term.kind == SINE:
            amplitude, omega, phase = m.term_data[first], m.term_data[first + 1], m.term_data[first + 2]
            s, c = np.sin(omega * t + phase), np.cos(omega * t + phase)
            df, dg, dh = amplitude * s, amplitude * omega * c, -amplitude * omega * omega * s
        else:
            df, dg, dh = spline(m.term_data, first, t)
        f, g, h = f + df, g + dg, h + dh
    return f, g, h
