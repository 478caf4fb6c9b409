"""Signals: derivatives against differences, algebra, the lowered terms, the compiled twin, and every refusal."""

import doctest
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from mbsd3d import Constant, Input, Polynomial, Pulse, Ramp, Sine, Table
from mbsd3d.equations.compiled import Signals
from mbsd3d.extend import evaluate
from mbsd3d.kernels import signals as kernels
from mbsd3d.mechanism.signals import check_interval, curves
from mbsd3d.mechanism.signals import signal as bases
from mbsd3d.mechanism.signals.terms import turning_times
from mbsd3d.signals import Scaled, Sum, as_signal

TIMES = np.array([0.0, 0.4, 0.7, 1.3, 1.9, 2.2])
TABLE = Table(TIMES, np.cos(3.0 * TIMES))
SIGNALS = {
    "constant": Constant(1.7),
    "ramp": Ramp(rate=-0.8, offset=0.3),
    "sine": Sine(amplitude=0.6, frequency=1.4, phase=0.5, offset=-0.2),
    "polynomial": Polynomial([0.3, -1.1, 0.7, 0.25, -0.1]),
    "pulse": Pulse(height=1.3, start=0.3, edge=0.6, duration=1.5),
    "step": Pulse(height=-0.8, start=0.3, edge=0.6),
    "table": TABLE,
    "sum": 2.0 - 3.0 * (TABLE + Sine(0.6, 1.4)) + Polynomial([0.1, 0.2, 0.3]),
}
# inside the table, away from its ends and breaks
INSIDE = np.array([0.13, 0.55, 1.01, 1.62, 2.05])


@pytest.fixture(params=SIGNALS.values(), ids=SIGNALS)
def signal(request):
    return request.param


def test_examples():
    for module in (curves, bases):
        result = doctest.testmod(module)
        assert result.attempted and not result.failed


def test_derivatives_are_those_of_the_value(signal):
    h = 1e-4
    slope = (signal(INSIDE + h) - signal(INSIDE - h)) / (2 * h)
    bend = (signal.derivative(INSIDE + h) - signal.derivative(INSIDE - h)) / (2 * h)
    # central difference: h^2 f'''/6 with f''' up to 1.8 * 8.8^3 = 1200, f'''' 10 000 (the sine in the sum)
    np.testing.assert_allclose(signal.derivative(INSIDE), slope, rtol=0, atol=2.5e-6)
    np.testing.assert_allclose(signal.second_derivative(INSIDE), bend, rtol=0, atol=2e-5)


def test_values_are_those_of_the_formulas():
    t = INSIDE
    np.testing.assert_array_equal(SIGNALS["constant"](t), np.full(5, 1.7))
    np.testing.assert_allclose(SIGNALS["ramp"](t), 0.3 - 0.8 * t, rtol=1e-15)
    np.testing.assert_allclose(SIGNALS["sine"](t), -0.2 + 0.6 * np.sin(2 * np.pi * 1.4 * t + 0.5), rtol=1e-14)
    expected = 0.3 - 1.1 * t + 0.7 * t**2 + 0.25 * t**3 - 0.1 * t**4
    np.testing.assert_allclose(SIGNALS["polynomial"](t), expected, rtol=1e-13)
    combined = 2 - 3 * TABLE(t) - 1.8 * np.sin(2 * np.pi * 1.4 * t) + 0.1 + 0.2 * t + 0.3 * t**2
    np.testing.assert_allclose(SIGNALS["sum"](t), combined, rtol=1e-13)


def test_any_shape_of_times(signal):
    grid = INSIDE[:4].reshape(2, 2)
    for function in (signal, signal.derivative, signal.second_derivative):
        assert np.shape(function(0.5)) == ()
        assert function(grid).shape == (2, 2)
        assert function(np.empty(0)).shape == (0,)
        np.testing.assert_array_equal(function(grid).ravel(), [function(t) for t in grid.ravel()])


def test_terms_are_laid_out_as_documented():
    (constant,) = Constant(1.7).terms()
    assert constant.data.tolist() == [1.7]
    (ramp,) = Ramp(2.0, 0.5).terms()
    assert (ramp.kind, ramp.data.tolist()) == (constant.kind, [0.5, 2.0])
    sine, offset = Sine(0.6, 1.5, 0.5, 0.2).terms()
    assert sine.data.tolist() == [0.6, 3.0 * np.pi, 0.5]
    assert (offset.kind, offset.data.tolist()) == (constant.kind, [0.2])
    (spline,) = TABLE.terms()
    assert len({constant.kind, sine.kind, spline.kind}) == 3
    assert spline.data[0] == len(TIMES) - 1
    np.testing.assert_array_equal(spline.data[1:7], TIMES)
    np.testing.assert_allclose(spline.data[7:].reshape(5, 4)[:, 3], TABLE.values[:-1], rtol=1e-15)


def test_pulse_is_zero_outside_and_its_height_within():
    for edge in (0.3, 0.75):  # the second has no time between rise and fall
        pulse = Pulse(height=2.0, start=0.5, edge=edge, duration=1.5)
        np.testing.assert_array_equal(pulse([-5.0, 0.5, 2.0, 9.0]), np.zeros(4))
        np.testing.assert_allclose(pulse([0.5 + edge, 2.0 - edge]), 2.0, rtol=1e-14)
        t = np.linspace(0.0, 2.5, 20001)
        assert abs(np.trapezoid(pulse(t), t) - 2.0 * (1.5 - edge)) < 1e-7  # spacing^2 times the largest slope
    assert Pulse(2.0, 0.5, 0.3)(1e6) == 2.0


def test_table_goes_through_its_points_with_smooth_slopes():
    np.testing.assert_allclose(TABLE(TIMES), TABLE.values, rtol=0, atol=1e-15)
    eps = 1e-9
    for function in (TABLE.derivative, TABLE.second_derivative):
        # jump of a continuous function across 2 eps: 2 eps times a slope of at most 50
        np.testing.assert_allclose(function(TIMES[1:-1] + eps), function(TIMES[1:-1] - eps), rtol=0, atol=1e-7)


def test_table_reproduces_a_cubic():
    cubic = Polynomial([0.5, -2.0, 0.3, 0.7])
    table = Table(TIMES, cubic(TIMES))
    for name in ("__call__", "derivative", "second_derivative"):
        # rounding of 1e-16 divided by the shortest interval squared, 0.09
        np.testing.assert_allclose(getattr(table, name)(INSIDE), getattr(cubic, name)(INSIDE), rtol=0, atol=1e-13)


def test_table_keeps_its_own_numbers():
    values = np.array([1.0, 2.0, 4.0, 8.0])
    table = Table([0, 1, 2, 3], values)
    values[0] = 99.0
    assert table(0.0) == 1.0
    with pytest.raises(ValueError, match="read-only"):
        table.values[0] = 99.0


def test_algebra_with_numbers_on_either_side(signal):
    value = signal(INSIDE)
    for other in (2.5, np.float64(2.5), np.int64(2)):
        np.testing.assert_allclose((signal + other)(INSIDE), value + other, rtol=1e-14)
        np.testing.assert_allclose((other + signal)(INSIDE), value + other, rtol=1e-14)
        np.testing.assert_allclose((other - signal)(INSIDE), other - value, rtol=1e-14)
        np.testing.assert_allclose((signal - other)(INSIDE), value - other, rtol=1e-14)
        np.testing.assert_allclose((other * signal)(INSIDE), other * value, rtol=1e-13)
        np.testing.assert_allclose((signal * other)(INSIDE), other * value, rtol=1e-13)
    np.testing.assert_array_equal((-signal)(INSIDE), -value)
    np.testing.assert_allclose(sum([signal, signal])(INSIDE), 2 * value, rtol=1e-14)


def test_a_long_series_is_one_sum():
    """A thousand harmonics added one by one, against numpy; a sum in a sum would nest as deep."""
    t, orders = 0.37, np.arange(1, 1001)
    series = sum(Sine(1.0 / k, float(k), phase=0.1 * k) for k in orders)
    assert float(series(t)) == pytest.approx((np.sin(2 * np.pi * orders * t + 0.1 * orders) / orders).sum(), abs=1e-11)
    assert all(not isinstance(one, Sum) for one in series.signals)


def test_products_and_nestings_made_by_loops_are_no_deeper_than_their_parts():
    """1200 products ended in a RecursionError. s -> a (s + r) is a geometric sum: r a (1 - a^n) / (1 - a) + a^n s."""
    damped, negated, folded = Sine(0.7, 1.3, 0.2), Ramp(0.4, 0.1), Ramp(0.4, 0.1)
    for _ in range(1201):
        damped, negated = 0.999 * damped, -negated
    for _ in range(150):
        folded = Scaled(Sum((folded, Constant(2.0))), 0.9) - 0.3
    t, a = 0.37, 0.9**150
    assert float(damped(t)) == pytest.approx(0.999**1201 * float(Sine(0.7, 1.3, 0.2)(t)), rel=1e-12)
    assert float(negated.derivative(t)) == -0.4 and isinstance(negated.signal, Ramp)
    assert float(folded(t)) == pytest.approx(a * (0.4 * t + 0.1) + 1.5 * (1 - a) / 0.1, rel=1e-12)
    assert all(not isinstance(one, Scaled) or isinstance(one.signal, Ramp | Constant) for one in folded.signals)
    assert eval(repr(folded), vars(curves) | vars(bases)) == folded == pickle.loads(pickle.dumps(folded))


def test_a_product_beyond_what_can_be_computed_with_is_refused():
    signal = Ramp(1.0)
    with pytest.raises(ValueError, match=r"Scaled: factor: 1.*e\+6\d is outside .* check the units"):
        for _ in range(1200):
            signal = 10.0 * signal


def test_an_input_in_nested_products_keeps_all_factors():
    (term,) = (2.0 * (-3.0 * (0.5 * Input("throttle", 4.0)))).terms()
    assert (term.data.tolist(), term.input, term.factor) == ([-12.0, 0.0], ("throttle", 4.0), -3.0)


def test_interval_is_what_all_tables_share():
    late = Table(TIMES + 0.5, TIMES)
    assert Sine(1.0, 2.0).interval == (-np.inf, np.inf)
    assert (3.0 * TABLE + 1.0).interval == (0.0, 2.2)
    assert (TABLE + late).interval == (0.5, 2.2)
    check_interval(TABLE, 0.0, 2.2 * (1 + 1e-15), "driver 'motor'")
    check_interval(Ramp(1.0), 0.0, 1e9, "driver 'motor'")
    with pytest.raises(ValueError, match="driver 'motor': the table covers 0 s to 2.2 s and is asked for 0 s to 3 s"):
        check_interval(TABLE, 0.0, 3.0, "driver 'motor'")
    with pytest.raises(ValueError, match="Sum: the table covers 0.5 s to 2.2 s and is asked for 0.1 s to 1 s; extend"):
        (TABLE + late)(np.array([1.0, 0.1]))
    with pytest.raises(ValueError, match="one starts at 10 s, when another has ended at 2.2 s; give tables"):
        TABLE + Table(TIMES + 10.0, TIMES)


def test_compiled_meaning_is_the_same(signal):
    """The kernel on the lowered terms, packed as the model packs them; beyond the ends of a table too."""
    terms, tables = signal.terms(), Signals()
    tables.add(Constant(7.0))  # the signal is not the first one in the tables
    tables.add(signal)
    spans = np.array(tables.spans, [("first", int), ("end", int)])
    parts = np.array(tables.terms, [("kind", int), ("first", int), ("end", int)])
    data = np.concatenate(tables.data)
    model = SimpleNamespace(signal=spans.view(np.recarray), term=parts.view(np.recarray), term_data=data)
    kernel = getattr(kernels.signal, "py_func", kernels.signal)
    for t in (*INSIDE, *TIMES, -0.3, 2.9):
        expected = [evaluate(terms, t, order) for order in (0, 1, 2)]
        # other order of the operations: rounding of numbers up to 1e2
        np.testing.assert_allclose(kernel(model, 1, t), expected, rtol=1e-12, atol=1e-12)


def test_as_signal():
    assert as_signal(SIGNALS["sum"], "speed") is SIGNALS["sum"]
    assert as_signal(3, "speed") == Constant(3.0)
    assert as_signal(np.float32(0.5), "speed") == Constant(0.5)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: as_signal(np.nan, "driver 'motor': speed"), "driver 'motor': speed is nan; give a finite number or a"),
        (lambda: as_signal("fast", "driver 'motor': speed"), "driver 'motor': speed is 'fast'; give .* into a Table"),
        (lambda: as_signal(np.sin, "speed"), "speed is <ufunc 'sin'>"),
        (lambda: Constant(np.inf), "Constant: value is inf; give a finite number"),
        (lambda: Ramp("up"), "Ramp: rate is 'up'"),
        (lambda: Sine(1.0, np.nan), "Sine: frequency is nan"),
        (lambda: np.nan * Ramp(1.0), "Scaled: factor is nan"),
        (lambda: Ramp(1.0) + np.inf, "sum of signals is inf"),
        (lambda: Polynomial([]), "Polynomial: coefficients is empty; give at least the constant c0"),
        (lambda: Polynomial(3.0), r"Polynomial: coefficients has shape \(\); give a row"),
        (lambda: Polynomial([1.0, np.nan]), r"Polynomial: coefficients: \[ 1., nan\] is not finite"),
        (lambda: Polynomial("abc"), "Polynomial: coefficients: 'abc' is not numeric"),
        (lambda: Pulse(1.0, 0.0, 0.0), "Pulse: edge is 0 s; give a positive time"),
        (lambda: Pulse(1.0, 0.0, 0.2, 0.3), "Pulse: duration is 0.3 s; give at least two edges, 0.4 s"),
        (lambda: Table([0, 1, 2, 3], [1, 2, 3]), "Table: 4 times but 3 values; give one value per time"),
        (lambda: Table([0, 1, 2], [1, 2, 3]), "Table: 3 points; a cubic spline needs 4"),
        (lambda: Table([0, 1, 1, 2], np.ones(4)), r"Table: times\[2\] = 1 does not come after times\[1\] = 1; sort"),
        (lambda: Table([0, 1, 2, np.nan], np.ones(4)), r"Table: times: .* is not finite"),
        (lambda: TABLE(2.5), "Table: the table covers 0 s to 2.2 s and is asked for 2.5 s to 2.5 s"),
        (lambda: TABLE.derivative(np.nan), "Table: t: nan is not finite; give times"),
        (lambda: evaluate(TABLE.terms(), 1.0, 3), "evaluate: order is 3; give 0, 1 or 2"),
    ],
)
def test_refusals(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_other_types_do_not_combine():
    for operation in (lambda: TABLE + "1", lambda: TABLE * TABLE, lambda: [1] - TABLE):
        with pytest.raises(TypeError):
            operation()
    assert isinstance(Ramp(1.0) + Ramp(2.0), Sum)


def turns(signal):
    """Times at which the only term of a signal turns."""
    (term,) = signal.terms()
    return turning_times(np.asarray(term.data, float))


def test_a_pulse_turns_at_the_ends_of_its_edges_where_its_second_derivative_jumps():
    times, jumps = turns(-2.0 * Pulse(3.0, 1.0, 0.1, 0.5))
    np.testing.assert_allclose(times, [1.0, 1.1, 1.4, 1.5], rtol=1e-15)
    assert jumps.all()


def test_a_table_turns_at_its_extremes_and_where_it_is_flat_on_one_side():
    t = np.linspace(0.0, 2.0, 401)
    times, jumps = turns(Table(t, 0.3 + np.sin(2 * np.pi * t)))
    np.testing.assert_allclose(times, [0.25, 0.75, 1.25, 1.75], rtol=0, atol=0.0051)
    assert not jumps.any()
    ramp = np.clip(t - 0.5, 0.0, 0.5)
    ripple = 1e-4 * np.sin(300.0 * t) * (t > 1.2)  # too small to be a pulse
    times, _ = turns(Table(t, ramp))
    assert times.size <= 6 and np.abs(times[:, None] - [0.5, 1.0]).min(axis=0).max() < 0.01  # it swings at corners
    assert (turns(Table(t, ramp + ripple))[0] > 1.3).sum() <= 4  # of 38 swings
    assert turns(Table(t, np.full(401, 7.0)))[0].size == 0


def test_a_table_of_noise_turns_about_as_often_as_its_values():
    rng = np.random.default_rng(4)
    t = np.cumsum(rng.uniform(0.01, 0.02, 3000))
    values = rng.normal(size=3000)
    times, jumps = turns(Table(t, values))
    extremes = np.count_nonzero(np.diff(values)[1:] * np.diff(values)[:-1] < 0.0)
    assert 0.9 * extremes < times.size < 1.2 * extremes
    assert (np.diff(times) > 0.0).all() and not jumps.any()


def test_a_table_comes_from_a_file(tmp_path):
    path = tmp_path / "shaker.csv"
    path.write_text("t [s], offset, force [N]\n" + "".join(f"{t},{-t},{t**3}\n" for t in (0.0, 0.5, 1.0, 2.0)))
    named = Table.from_csv(path, times="t [s]", values="force [N]")
    assert float(named(1.5)) == pytest.approx(1.5**3, abs=1e-14)
    assert float(Table.from_csv(path, values=1)(1.5)) == pytest.approx(-1.5, abs=1e-14)
    path.write_text("0,1\n1,2\n2,3\n3,4\n")
    assert Table.from_csv(path).interval == (0.0, 3.0)  # a first row of numbers counts


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        ("t,f\n0,1\n", {"values": "g"}, "no column 'g'; give one of t, f, or a number from 0"),
        ("t,f\n0,1\n", {"values": 2}, "no column 2; give one of t, f"),
        ("t,f\n0,1\n1,x\n", {}, "row 3, '1,x', has no two numbers; correct it"),
        ("t,f\n0,1\n1\n", {}, "row 3, '1', has no two numbers"),
        ("t,f\n0,1\n", {}, "Table: 1 point; a cubic spline needs 4"),
        ("0,x\n1,2\n2,3\n3,4\n4,5\n", {}, "row 1, '0,x', has no two numbers"),  # no row of titles
    ],
)
def test_files_without_a_table_are_refused(tmp_path, text, given, message):
    path = tmp_path / "shaker.csv"
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        Table.from_csv(path, **given)
    assert message in str(error.value)
    with pytest.raises(ValueError, match="cannot be read"):
        Table.from_csv(tmp_path / "none.csv")
