"""Your own bicycle from a file: at which speeds is it stable, how sure is that, and what would more trail do?

The file beside this script, `own_bicycle.txt`, has one measured number a line, `value +/- deviation`.

Prints::

    own_bicycle: 23.06 kg, 31.9 % of the weight in front
    stable by itself: 4.033079 ... 4.295428 m/s
    capsize speed 4.295428 m/s, by the determinant 4.295428 m/s
    10000 samples of own_bicycle   2.5 %    median    97.5 %   [m/s]
      weave speed             3.9229    4.0334    4.1434   in 100.0 % of them
      capsize speed           4.1333    4.2958    4.4546   in 100.0 % of them
      lowest stable speed     3.9229    4.0334    4.1434   in 100.0 % of them
      stable width            0.1954    0.2618    0.3263   in 100.0 % of them
    own_bicycle: c = -0.04 ... 0.14 m, 91 values
      c = -0.04 m: stable at no speed
      c = 0.14 m: stable 4.125213 ... 4.886020 m/s
      lowest stable speed 3.99558 m/s at c = 0.034 m
      self-stable at some speed for 54 values
"""

from pathlib import Path

import numpy as np

from bicycle import equations, named, sensitivity, stability

mine = named(Path(__file__).with_suffix(".txt"))
print(f"{mine.name}: {mine.mass:.2f} kg, {100 * mine.front_load:.1f} % of the weight in front")
critical = stability.study(mine).critical
print("stable by itself:", *critical.stable)

linear = equations.canonical(mine)  # M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 of lean and steer
(a, b), (c, d), (e, f) = linear.K0[0], linear.K0[1], linear.K2[:, 1]  # the lean column of K2 is zero
capsize = np.sqrt(-linear.g * (a * d - b * c) / (a * f - c * e))  # where det(g K0 + v^2 K2) = 0
print(f"capsize speed {critical.capsize:.6f} m/s, by the determinant {capsize:.6f} m/s")

spread = sensitivity.monte_carlo(mine)
print(spread)
trails = sensitivity.stable_speeds(mine, "c", np.linspace(-0.04, 0.14, 91))
print(trails)
figure = trails.figure()
