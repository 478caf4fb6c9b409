"""The Fourier helper: exact for whole periods, windows against their closed forms."""

import numpy as np
import pytest
from scipy.signal import get_window

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Distance,
    Force,
    Kinematic,
    Polynomial,
    Prismatic,
    Ramp,
    Revolute,
    Sine,
    System,
    Universal,
    measures,
    rotation,
    simulate,
    spectrum,
)
from mbsd3d.errors import InputError
from mbsd3d.results.spectrum import WINDOWS

RATE, RNG = 7.3, np.random.default_rng(5)


def taper(window, n):
    return get_window(WINDOWS[window], n)


def gain(window, offset, n):
    """Complex W(d) / W(0): how a bin of a record of n samples sees a tone d = ``offset`` bins above it."""
    weights = taper(window, n)
    return np.exp(2j * np.pi * np.multiply.outer(offset, np.arange(n)) / n) @ weights / weights.sum()


C = RNG.normal(size=(4, 2)) + 1j * RNG.normal(size=(4, 2))
ORDERS = np.array([0.0, 1.0, 2.0, 4.5])
C[0] = C[0].real


def tones(t):
    """sum Re(c exp(i order w t)), (n, 2)."""
    return np.real(np.exp(1j * RATE * np.outer(t, ORDERS)) @ C)


@pytest.mark.parametrize("repeated", [True, False])
@pytest.mark.parametrize("start", [0.0, 0.37])
@pytest.mark.parametrize("samples", [38, 39])
def test_exact_over_whole_periods(repeated, start, samples):
    """Two turns, so that half orders are whole; even and odd numbers of samples."""
    t = start + 2 * (2 * np.pi / RATE) / samples * np.arange(samples + repeated)
    found = spectrum(t, tones(t), rate=RATE)
    assert len(found.orders) == samples // 2 + 1
    exact = np.zeros((len(found.orders), 2), complex)
    exact[(2 * ORDERS).astype(int)] = C
    assert np.abs(found.amplitudes - exact).max() < 1e-14 * 5  # a sum of 40 numbers of order one
    assert np.array_equal(found.at(4.5), found.amplitudes[9])
    again = spectrum(t, tones(t)[:, 1], rate=RATE)
    assert np.array_equal(again.amplitudes, found.amplitudes[:, 1])
    assert found.frequency == pytest.approx(found.orders * RATE)


def test_frequencies_in_hertz():
    t = np.linspace(0, 3 * 2 * np.pi / RATE, 61)
    for times in (t, t[:-1]):  # with and without the repeated sample
        values = np.cos(RATE * times - 0.4)
        assert abs(spectrum(times, values).at(RATE / (2 * np.pi)) - np.exp(-0.4j)) < 1e-14


def test_sum_of_amplitudes_gives_the_values_back():
    """Any samples, the half sampling rate among them."""
    t, values = 0.3 + 0.1 * np.arange(16), RNG.normal(size=16)
    found = spectrum(t, values, rate=2 * np.pi / 1.6)
    assert np.real(np.exp(1j * np.outer(t, found.frequency)) @ found.amplitudes) == pytest.approx(values, abs=1e-13)


@pytest.mark.parametrize("window", WINDOWS)
def test_scalloping_is_the_closed_form(window):
    """A tone between two bins: c = A gain(d) + conj(A) gain of its image, to rounding."""
    n, c = 128, 1.3 * np.exp(0.7j)
    t = 0.05 * np.arange(n)
    for offset in (0.0, 0.31, 0.5):
        bins = 20 + offset
        values = np.real(c * np.exp(2j * np.pi * bins * t / (n * 0.05)))
        found = spectrum(t, values, window=window).amplitudes[20]
        assert abs(found - c * gain(window, offset, n) - np.conj(c) * gain(window, -bins - 20, n)) < 1e-14 * 10
    loss = 1 - abs(gain(window, 0.5, 10_000))
    assert loss == pytest.approx({"none": 0.3634, "hann": 0.1512, "flat top": 0.0011}[window], abs=1e-4)
    mean = {"none": 1.0, "hann": 0.5, "flat top": 0.21557895}[window]  # a_0 of its cosines
    assert taper(window, 8).mean() == pytest.approx(mean)


def test_windows_read_amplitudes_of_records_that_are_no_whole_periods():
    t = np.linspace(0, 10.3 * 2 * np.pi / RATE, 700)
    values = 2.0 * np.cos(RATE * t + 0.3) + 0.1 * np.cos(4 * RATE * t)
    errors = {w: abs(abs(spectrum(t, values, rate=RATE, window=w).at(1)) - 2.0) / 2.0 for w in ("hann", "flat top")}
    assert errors["hann"] < 0.16 and errors["flat top"] < 0.002  # scalloping of the windows, and a little leakage
    assert errors["hann"] > 10 * errors["flat top"]


def test_errors_name_sample_and_remedy():
    t = np.linspace(0, 2 * np.pi / RATE, 33)
    for arguments, options, message in (
        ((t**2, t), {}, "is .* off even steps .* ask the run for a number of samples"),
        ((t, np.where(t > 0.5, np.nan, t)), {}, "values is not finite at sample 19"),
        ((t, t[:-1]), {}, "n >= 3"),
        ((t, t), {"rate": 1.1 * RATE}, r"is 1.1 periods long, 1.13\d* if .* whole periods, at least one, or a window"),
        ((t, t), {"rate": 0.4 * RATE}, "is 0.4 periods long"),
        ((t, t), {"rate": 0.0}, "rate is 0, so there are no orders; give the speed"),
        ((t, np.exp(1j * t)), {}, "values of type complex128; give real numbers"),
        ((t[::-1], t), {}, "t goes from 0.8607.* s to 0 s; give times that increase"),
        ((t, [[1.0], [1.0, 2.0]]), {}, "values: .* has rows of different lengths"),
        ((t, np.zeros((33, 0))), {}, r"values \(33, 0\); give .* k >= 1"),
        ((t, 1e308 * np.cos(t)), {}, "values: 1e\\+308 is beyond the largest magnitude 1e\\+60; check the units"),
        (([0.0], [1.0]), {}, r"t \(1,\) and values \(1,\); give .* n >= 3"),
        ((t, t), {"window": "hamming"}, "window 'hamming' is unknown; give 'none' or 'hann' or 'flat top'"),
    ):
        with pytest.raises(ValueError, match=message):
            spectrum(*arguments, **options)
    with pytest.raises(ValueError, match="no bin at order 1.5"):
        spectrum(t, t, rate=RATE).at(1.5)
    with pytest.raises(ValueError, match="no bin at order 40"):
        spectrum(t, t, rate=RATE, window="hann").at(40)


def test_a_shaft_that_turns_backwards():
    """Orders count turns; amplitudes and phases are those of time, whichever way the shaft turns."""
    t = np.linspace(0.2, 0.2 + 2 * np.pi / RATE, 33)
    found = spectrum(t, tones(2 * t), rate=-2 * RATE)
    assert np.array_equal(found.amplitudes, spectrum(t, tones(2 * t), rate=2 * RATE).amplitudes)
    assert np.abs(found.at(1) - C[1]).max() < 1e-14 * 5


def test_phases_far_from_the_start():
    """A million seconds: the step is known to 1e-10 s of rounding, the period exactly."""
    t = 1e6 + np.linspace(0, 2 * np.pi / RATE, 33)
    found = spectrum(t, np.cos(RATE * t + 0.4), rate=RATE).at(1)
    assert abs(found - np.exp(0.4j)) < 1e-8  # rounding of w t, 7e6: 1e-9


def test_columns_decide_for_themselves_whether_they_repeat():
    """Newtons beside a small angle that has not come back."""
    t = np.linspace(0.0, 1.0, 41)
    values = np.column_stack([1e9 * np.cos(4 * np.pi * t), 0.1 * t])
    assert spectrum(t, values).orders[1] == pytest.approx(1 / (41 * t[1]))
    assert spectrum(t, values[:, 0]).orders[1] == pytest.approx(1.0)


def shaken_block():
    """A block on which a force of 6 N at 5 Hz acts, with a steady push."""
    block = Body("block", 2.0, (1, 1, 1), com=(0.1, 0.2, -0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    push = Force(block, (1.0 + Sine(6.0, 5.0), Sine(1.0, 8.0), 0), at=block.centre, name="push")
    return block, push, System([block], forces=[push], gravity=(0, 0, 0))


def test_spectrum_of_a_solution():
    block, push, system = shaken_block()
    run = simulate(system, 2.0, output=401)
    seen = run.spectrum("acceleration", "block")
    assert seen.unit == "m/s^2" and seen.names == ("x", "y", "z") and seen.name == "acceleration of block"
    assert np.abs(seen.at(5.0) - [-3j, 0, 0]).max() < 1e-12 and np.abs(seen.at(8.0) - [0, -0.5j, 0]).max() < 1e-12
    assert np.abs(seen.at(0.0) - [0.5, 0, 0]).max() < 1e-12
    force = run.spectrum("force", push, after=1.0)
    assert abs(abs(force.at(5.0)[0]) - 6.0) < 1e-12 and abs(force.at(5.0)[0] + 6j) < 1e-9
    levels = seen.levels()
    k = int(np.argmin(np.abs(seen.orders - 5.0)))
    assert levels.unit == "dB re 1e-06 m/s^2" and abs(levels.values[k, 0] - 20 * np.log10(3e6 / np.sqrt(2.0))) < 1e-9
    assert abs(levels.values[0, 0] - 20 * np.log10(0.5e6)) < 1e-9
    place = run.spectrum(measures.position(block, axis=(1, 0, 0)), window="hann")
    with pytest.raises(InputError, match="levels: no usual reference for a quantity in m; give reference="):
        place.levels()
    assert place.levels(1e-12).unit == "dB re 1e-12 m"


def test_density_of_a_solution_sums_to_the_variance():
    _, push, system = shaken_block()
    run = simulate(system, 20.0, output=2001)
    found = run.density("force", push, segments=4)
    assert found.unit == "(N)^2/Hz" and found.density.shape == (found.hertz.size, 3)
    variance = found.density.sum(axis=0) * found.hertz[1]
    assert np.abs(variance - [18.0, 0.5, 0.0]).max() < 1e-2  # of sines over segments of broken periods
    assert abs(found.hertz[np.argmax(found.density[:, 0])] - 5.0) <= found.hertz[1]


@pytest.mark.parametrize("window, half_a_bin", [("none", 1.909859317102744), ("hann", 2.5464790894703255)])
def test_a_tone_half_a_bin_off(window, half_a_bin):
    n, k = 1024, 128
    t = np.arange(n) / n
    for off, size, rtol in ((0.0, 3.0, 1e-12), (0.5, half_a_bin, 3e-3)):  # limits of long records: 2/pi, 8/(3 pi)
        found = spectrum(t, 3.0 * np.cos(2.0 * np.pi * (k + off) * t + 0.3), window=window)
        assert np.abs(found.amplitudes[k]) == pytest.approx(size, rel=rtol)


def cardan(drive):
    """Two shafts at 30 degrees, the first driven."""
    beta = np.radians(30.0)
    way = np.array([np.cos(beta), np.sin(beta), 0.0])
    one = Body("one", 1.0, (0.2, 0.3, 0.3), position=(-0.5, 0, 0))
    two = Body("two", 1.0, (0.2, 0.3, 0.3), position=0.5 * way, orientation=rotation("z", beta))
    input_bearing = Revolute(GROUND, one, at=(-0.5, 0, 0), axis=(1, 0, 0), name="input")
    output_bearing = Revolute(GROUND, two, at=way, axis=way, name="output")
    joints = [input_bearing, output_bearing, Universal(one, two, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1))]
    return System([one, two], [*joints, AngleDriver(input_bearing, drive, name="motor")], gravity=(0, 0, 0))


@pytest.mark.parametrize("rate", [7.0, -7.0])
def test_orders_of_a_cardan_joint(rate):
    """Speed of the driven shaft over that of the other: 2 tan(beta/2)^2n at the even orders, nothing at odd ones."""
    run = simulate(cardan(Ramp(rate)), 2.2, method=Kinematic(), output=200)
    seen = run.orders("input", measures.rate(run.system.part("output", "joints")), per_turn=64)
    for n in (1, 2, 3):
        assert abs(abs(seen.at(2 * n)) / 7.0 - 2.0 * np.tan(np.radians(15.0)) ** (2 * n)) < 1e-9  # kinematic: 1e-10
    assert max(abs(seen.at(order)) for order in (1, 3, 5)) < 1e-8
    assert seen.at(0) == pytest.approx(rate) and seen.unit == "rad/s" and seen.frequency[2] == pytest.approx(7.0)


def test_orders_where_the_speed_varies():
    """A quantity that depends on the angle alone has the same orders at any speed."""
    run = simulate(cardan(Ramp(7.0) + Sine(0.4, 0.6)), 2.2, method=Kinematic(), output=200)
    plain = simulate(cardan(Ramp(7.0)), 2.2, method=Kinematic(), output=200)
    uneven, even = (
        x.orders("input", measures.lean(x.system.part("two"), lateral=(0, 0, 1)), per_turn=128) for x in (run, plain)
    )
    count = min(uneven.orders.size, even.orders.size)
    assert count > 60 and uneven.orders[1] == even.orders[1] == 0.5
    assert np.abs(uneven.amplitudes[:count] - even.amplitudes[:count]).max() < 1e-8
    assert uneven.frequency[2] == pytest.approx(7.0, rel=0.2)


@pytest.mark.parametrize("rate", [10.0, -10.0])
def test_frequency_of_an_order_over_a_single_uneven_turn(rate):
    """The mean speed is that of whole turns: angle = rate t + 0.5 sin(rate t) takes 2 pi / |rate| for each."""
    disc = Body("disc", 1.0, (0.1, 0.1, 0.1))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    driver = AngleDriver(hinge, Ramp(rate) + Sine(0.5 * np.sign(rate), abs(rate) / (2 * np.pi)))
    run = simulate(System([disc], [hinge, driver]), 2.001 * np.pi / abs(rate), method=Kinematic(), output=100)
    assert run.orders(hinge, "rate", hinge).frequency[1] == pytest.approx(10.0, rel=1e-8)


def slider_crank(ratio):
    """Crank of radius 0.05 m at a constant speed with a piston along x, r / l = ratio, no offset."""
    r, rate = 0.05, 20.0
    crank = Body("crank", 1.0, (0.01,) * 3, com=(0, 0.01, 0))
    piston = Body("piston", 0.5, (0.01,) * 3, position=(r + r / ratio, 0, 0))
    main = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="main")
    rod = Distance(crank, piston, at_a=(r, 0, 0), at_b=piston.position)
    guide = Prismatic(GROUND, piston, at=piston.position, axis=(1, 0, 0), name="guide")
    return System([crank, piston], [main, rod, guide, AngleDriver(main, Ramp(rate), name="motor")]), r * rate**2


def test_orders_of_a_piston():
    """Acceleration over r w^2 at r / l = 0.3: Fourier sums of the exact second derivative, 4096 points."""
    system, size = slider_crank(0.3)
    run = simulate(system, 0.7, method=Kinematic(), output=100)
    found = run.orders("main", "acceleration", "piston").amplitudes[:, 0]
    orders = run.orders("main", "acceleration", "piston").orders
    for order, c in {1: 1.0, 2: 0.3070506590621658, 4: -0.007237694996821826, 6: 0.00019193674663593038}.items():
        assert abs(found[np.argmin(np.abs(orders - order))] / size + c) < 1e-8  # backwards at the outer dead centre
    assert run.orders("main", "reaction", "guide").unit == "N"


@pytest.mark.slow
def test_orders_of_a_run_whose_speed_varies_by_itself():
    """A wheel with an eccentric mass rolls off under gravity: the vertical reaction of its axle by the closed form."""
    m, e, inertia, start = 2.0, 0.1, 0.3, 12.0
    wheel = Body("wheel", m, (0.2, inertia, 0.2), com=(0, 0, e), omega=(0, start, 0), velocity=(0, 0, 0))
    axle = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 1, 0), name="axle")
    run = simulate(System([wheel], [axle]), 2.0, rtol=1e-11)
    seen = run.orders(axle, "reaction", axle, per_turn=256)
    angle = 2.0 * np.pi / 256 * np.arange(256)
    J = inertia + m * e * e
    square = start**2 + 2.0 * m * 9.81 * e * (1.0 - np.cos(angle)) / J  # energy, from the top
    alpha = m * 9.81 * e * np.sin(angle) / J
    vertical = m * (9.81 - e * (square * np.cos(angle) + alpha * np.sin(angle)))
    expected = np.fft.rfft(vertical) / 128
    expected[0] /= 2
    turns = round(1.0 / seen.orders[1])
    for order in range(4):
        assert abs(seen.amplitudes[order * turns, 2] - expected[order]) < 1e-6  # rtol of the run, forces of some 40 N


def running_up(quantity, part, **options):
    """A slider-crank at angle = 9 t + 4 t^2, and the waterfall of one of its quantities."""
    plain, _ = slider_crank(0.3)
    joints = [*plain.joints[:3], AngleDriver(plain.joints[0], Polynomial((0.0, 9.0, 4.0)), name="motor")]
    run = simulate(System(plain.bodies, joints), 6.0, method=Kinematic(), output=200)
    return run, run.waterfall("main", quantity, part, **options)


def test_waterfall_of_a_run_up():
    """What depends on the angle alone has the same orders in every window; the speed is that of its middle."""
    run, seen = running_up("position", "piston", turns=4, per_turn=64)
    turns = int((9.0 * 6.0 + 4.0 * 36.0) / (2.0 * np.pi))
    assert seen.t.size == (turns - 4) // 2 + 1 and seen.orders[1] == 0.25 and seen.unit == "m"
    assert np.abs(seen.speeds - (9.0 + 8.0 * seen.t)).max() < 1e-8  # of constant acceleration exact
    whole = run.orders("main", "position", "piston", per_turn=64)
    for order in (1, 2, 4):
        assert np.abs(seen.at(order) - whole.at(order)).max() < 1e-9
    assert np.array_equal(seen.frequencies[3], seen.speeds[3] * seen.orders)
    with pytest.raises(ValueError, match="no bin at order 1.1"):
        seen.at(1.1)
    with pytest.raises(ValueError, match="has 31 whole turns and a window 40"):
        run.waterfall("main", "position", "piston", turns=40)


@pytest.mark.parametrize(("turns", "per_turn"), [(4, 16), (3, 17)])
def test_a_fast_run_up_is_at_the_speed_of_the_middle_angle(turns, per_turn):
    """Load of a shaft with an eccentric mass, m e (w^2 n - alpha t): w^2 grows by 2 alpha with every radian.

    A window weighs angles, so its mean of w^2 is that of its middle angle. At its mean speed, which is that of the
    middle of its time, the load is less by up to a tenth here.
    """
    mass, e, start, alpha = 2.0, 0.15, 12.0, 14.0
    wheel = Body("wheel", mass, (0.1, 0.2, 0.3), com=(e, 0, 0.05))
    shaft = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    motor = AngleDriver(shaft, Polynomial((0.0, start, 0.5 * alpha)), name="motor")
    run = simulate(System([wheel], [shaft, motor], gravity=(0, 0, -9.81)), 6.0, method=Kinematic(), output=300)
    seen = run.waterfall(shaft, "reaction", shaft, turns=turns, per_turn=per_turn)
    starts = (turns * per_turn // 2) * np.arange(seen.t.size) * 2.0 * np.pi / per_turn
    speed = np.sqrt(start**2 + 2.0 * alpha * (starts + np.pi * turns))
    rounding = 1e-12 if turns * per_turn % 2 == 0 else 1e-4  # an odd count has its middle between two samples
    assert np.abs(seen.speeds / speed - 1.0).max() < rounding
    assert np.abs((start + alpha * seen.t) / speed - 1.0).max() < rounding
    exact = mass * e * np.hypot(speed**2, alpha)
    assert np.abs(abs(seen.at(1)[:, 0]) / exact - 1.0).max() < 1e-3  # its slope lets 7e-4 of the image in, at 6 bins
    ends = np.sqrt(np.array([starts, starts + 2.0 * np.pi * turns]) * 2.0 * alpha + start**2)
    assert np.abs((ends.mean(axis=0) / speed) ** 2 - 1.0).max() > 0.1


def test_figures_of_spectra():
    """Units on all axes, no bins beyond the last that counts, the orders named at the edge of a waterfall."""
    run, seen = running_up("acceleration", "piston", turns=4, per_turn=64)
    figure = seen.plot()
    axes, bar = figure.axes
    assert axes.get_ylabel() == "speed [rev/min]" and bar.get_ylabel() == "amplitude of acceleration of piston [m/s²]"
    assert {text.get_text() for text in axes.texts} == {"1×", "2×"}  # 4x is below 2 % of the first
    steady = simulate(slider_crank(0.3)[0], 2.0, method=Kinematic(), output=801)
    spectrum_of = steady.spectrum("acceleration", "piston", window="hann").plot(dark=True).axes[0]
    assert spectrum_of.get_xlabel() == "frequency [Hz]" and spectrum_of.get_xlim()[1] < 30.0  # 20 rad/s, sixth order
    assert [x.get_text() for x in spectrum_of.get_legend().get_texts()] == ["x", "y", "z"]
    orders = steady.orders("main", "effort", "motor").plot().axes[0]
    assert orders.get_xlabel() == "order" and orders.get_ylabel() == "amplitude of effort of motor [N m]"
    density = steady.density("acceleration", "piston").plot().axes[0]
    assert density.get_yscale() == "log" and density.get_ylabel() == "density of acceleration of piston [(m/s²)²/Hz]"
    with pytest.raises(ValueError, match="the speed is 20 rad/s all the time"):
        steady.waterfall("main", "effort", "motor", turns=2).plot()
    still = spectrum(np.arange(8.0), np.zeros(8)).plot()
    assert still.axes[0].get_ylabel() == "amplitude"


def test_what_solutions_refuse():
    block, push, system = shaken_block()
    run = simulate(system, 1.0)
    even = simulate(system, 1.0, output=101)
    for call, match in (
        (lambda: run.spectrum("acceleration", block), "ask the run for a number of samples"),
        (lambda: run.spectrum("jerk", block), "spectrum: quantity"),
        (lambda: run.spectrum("acceleration"), "acceleration of what"),
        (lambda: run.spectrum(measures.position(block, axis=(1, 0, 0)), block), "a measure already names its part"),
        (lambda: run.spectrum("force", push, after=2.0), "0 samples left"),
        (lambda: even.density("force", push, segments=0), "density: segments"),
    ):
        with pytest.raises(ValueError, match=match):
            call()
    pendulum = Body("bob", 1.0, (0.1, 0.1, 0.1), com=(0, 0, -1.0))
    hinge = Revolute(GROUND, pendulum, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    swing = System([pendulum], [hinge])
    run = simulate(swing, 3.0, state=swing.assemble(angles={hinge: 0.5}))
    with pytest.raises(InputError, match="orders: 'hinge' does not turn in one sense"):
        run.orders(hinge, "reaction", hinge)
