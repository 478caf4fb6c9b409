"""Spectra, densities and waterfalls: amplitudes over frequency, orders and speed, with their figures."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..base.errors import checks_arguments, checks_method_arguments
from ..base.fields import as_public
from ..results import spectrum as spectra

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checks_method_arguments
@dataclass(frozen=True, repr=False)
class Spectrum(spectra.Spectrum):
    """Amplitudes of ``values = sum_k Re(c_k exp(i w_k t))``, or of ``sum_k Re(c_k exp(i order_k angle))``.

    c = A exp(i phase) belongs to A cos(w t + phase): peak amplitudes, one-sided; c of order 0 is the mean.

    Attributes
    ----------
    orders : (bins,) array
        Multiples of the shaft speed; of a spectrum over time the frequency [Hz].
    amplitudes : (bins,) or (bins, k) complex array
        c in ``unit``.
    frequency : (bins,) array
        w [rad/s]; over orders that of the mean speed.
    window : str
    name, unit : str
        Quantity and part, and the unit of the amplitudes; empty for plain samples.
    names : tuple of str
        Of the k components.

    Examples
    --------
    >>> import numpy as np
    >>> from mbsd3d import spectrum
    >>> t = np.arange(100) / 100.0
    >>> spectrum(t, 2.0 + 3.0 * np.sin(2.0 * np.pi * 7.0 * t))
    <spectrum: 51 bins to 50, window 'none'; 2 at 0, 3 at 7>
    """

    def plot(self, *, dark: bool = False) -> "Figure":
        """Draw the amplitudes over frequency or orders with matplotlib, a colour per component."""
        from ..plotting.spectra import plot_spectrum

        return plot_spectrum(self, dark=dark)


@checks_method_arguments
@dataclass(frozen=True, repr=False)
class Density(spectra.Density):
    """One-sided power spectral density.

    Attributes
    ----------
    hertz : (bins,) array
        Frequency [Hz].
    density : (bins,) or (bins, k) array
        In ``unit``, the square of that of the quantity per Hz: its sum times the step is the variance.
    name, unit : str
    names : tuple of str
        Of the k components.

    Examples
    --------
    >>> from mbsd3d import Body, Force, Sine, System, simulate
    >>> block = Body("block", 2.0, (1, 1, 1), velocity=(0, 0, 0), omega=(0, 0, 0))
    >>> shaken = System([block], forces=[Force(block, (Sine(6.0, 5.0), 0, 0), name="push")])
    >>> found = simulate(shaken, 8.0, output=801).density("force", "push", segments=1)
    >>> found
    <density of force of push [(N)^2/Hz]: 401 bins to 49.9376 Hz>
    >>> variance = found.density[:, 0].sum() * found.hertz[1]  # A^2 / 2
    >>> round(float(variance), 1)
    18.0
    """

    def plot(self, *, dark: bool = False) -> "Figure":
        """Draw the density over frequency with matplotlib, a colour per component."""
        from ..plotting.spectra import plot_density

        return plot_density(self, dark=dark)


@checks_method_arguments
@dataclass(frozen=True, repr=False)
class Waterfall(spectra.Waterfall):
    """Amplitudes of a quantity over orders of a shaft, window by window, as its speed changes.

    Attributes
    ----------
    t : (n,) array
        When the shaft is in the middle of the turns of each window [s].
    speeds : (n,) array
        Speed of the shaft there [rad/s], positive: the one to which an amplitude belongs that grows with its square.
    orders : (bins,) array
        Multiples of the speed.
    amplitudes : (n, bins) or (n, bins, k) complex array
        c in ``unit``, peak amplitudes as of a `Spectrum`; of a window "hann".
    frequencies : (n, bins) array
        [rad/s]
    name, unit : str
    names : tuple of str
        Of the k components.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Polynomial, Revolute, System, simulate
    >>> arm = Body("arm", 2.0, (0.1, 0.1, 0.1), com=(0.25, 0, 0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    >>> motor = AngleDriver(hinge, Polynomial((0.0, 10.0, 5.0)), name="motor")
    >>> run = simulate(System([arm], [hinge, motor]), 5.0, method=Kinematic(), output=100)
    >>> found = run.waterfall(hinge, "effort", "motor", turns=4)
    >>> found
    <waterfall of effort of motor [N m]: 12 windows from 18.7437 to 55.8205 rad/s, orders to 64>
    >>> abs(found.at(1)).round(3)[[0, -1]]  # m g l
    array([4.905, 4.905])
    """

    def plot(self, *, dark: bool = False) -> "Figure":
        """Draw a map of the amplitude over frequency and speed with matplotlib: orders are rays, resonances columns."""
        from ..plotting.spectra import plot_waterfall

        return plot_waterfall(self, dark=dark)


@checks_arguments
def spectrum(t: ArrayLike, values: ArrayLike, *, rate: float | None = None, window: str = "none") -> Spectrum:
    """Compute the complex amplitudes of evenly sampled values; a last sample that repeats the first is left out.

    ``t`` (n,): evenly spaced times [s]; ``values`` (n,) or (n, k): real; ``rate``: of the shaft whose turn is order 1
    [rad/s], of either sign, amplitudes are those of time; without it orders are frequencies in Hz, and the last sample
    repeats the first if it equals it to 1e-9 of the largest value of each column; ``window``: "none" (whole periods
    only), "hann" or "flat top". ValueError for uneven samples, numbers that are not real or not finite, a record of a
    broken number of periods without a window.

    Examples
    --------
    >>> import numpy as np
    >>> from mbsd3d import spectrum
    >>> t = np.linspace(0, 1, 65)
    >>> spectrum(t, 3 * np.cos(4 * np.pi * t + 0.5), rate=2 * np.pi).at(2).round(6) == np.round(3 * np.exp(0.5j), 6)
    np.True_
    """
    return as_public(Spectrum, spectra.amplitudes(t, values, rate, window, one_unit=False))
