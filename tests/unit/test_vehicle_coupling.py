"""Contact forces over a step from values at communication points."""

import itertools

import numpy as np
import pytest
from force_memory import ForceMemory
from rail_vehicle import ForceHistory

RNG = np.random.default_rng(11)
COEFFICIENTS = RNG.normal(size=(3, 4, 6))
TIMES = (0.0, 1.0e-4, 3.0e-4)


def polynomial(time, degree):
    return sum(COEFFICIENTS[k] * (time * 1e4) ** k for k in range(degree + 1))


def history(degree, count):
    made = ForceHistory.begin(polynomial(TIMES[0], degree))
    for before, now in itertools.pairwise(TIMES[:count]):
        made = made.append(polynomial(now, degree), now - before)
    return made


def along(curve, s):
    return curve.start + (curve.end - curve.start) * s + curve.quadratic * s * (s - 1.0)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("s", [0.0, 0.3, 1.0])
def test_extrapolation_goes_along_its_polynomial(order, s):
    step = 2.5e-4
    curve = history(order, 3).extrapolate(step, order)
    assert along(curve, s) == pytest.approx(polynomial(TIMES[2] + s * step, order))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("s", [0.0, 0.3, 1.0])
def test_interpolation_goes_along_its_polynomial(order, s):
    curve = history(order, 3).interpolate(order)
    time = TIMES[1] + s * (TIMES[2] - TIMES[1])
    assert along(curve, s) == pytest.approx(polynomial(time, order))


def test_order_zero_holds_the_newest_value():
    made = history(2, 3)
    for curve in (made.interpolate(0), made.extrapolate(1e-4, 0)):
        assert along(curve, 0.4) == pytest.approx(made.forces[0])


def test_order_is_what_the_known_values_allow():
    assert along(history(2, 1).extrapolate(1e-4, 2), 0.7) == pytest.approx(polynomial(0.0, 2))
    line = history(2, 2).extrapolate(1e-4, 2)
    assert not line.quadratic.any()
    assert line.end == pytest.approx(2.0 * polynomial(1e-4, 2) - polynomial(0.0, 2))


def test_value_at_the_same_time_replaces_the_last():
    made = history(2, 3).append(np.ones((4, 6)), 0.0)
    assert made.ages == pytest.approx(history(2, 3).ages)
    assert np.array_equal(made.forces[0], np.ones((4, 6)))
    assert np.array_equal(made.forces[1:], history(2, 3).forces[1:])


def test_history_forgets_all_but_three():
    made = history(2, 3).append(np.ones((4, 6)), 5e-4)
    assert made.ages == pytest.approx([0.0, 5e-4, 7e-4])


def test_interpolation_needs_two_values():
    with pytest.raises(ValueError, match="both ends"):
        history(1, 1).interpolate(1)


def test_a_history_of_one_wheelset():
    made = ForceHistory.begin(np.ones((1, 6))).append(np.full((1, 6), 3.0), 1e-4)
    curve = made.extrapolate(1e-4, 1)
    assert curve.end.shape == (1, 6)
    assert curve.end == pytest.approx(np.full((1, 6), 5.0))


@pytest.mark.parametrize("at_end", [False, True])
def test_a_value_near_the_start_of_a_long_step_is_left_out(at_end):
    """Steps of 0.1 ms, then one of 1 ms: an error of the near value would be magnified."""
    step, times = 1e-3, [0.0, 1e-4, 2e-4, 3e-4]
    curves = []
    for error in (0.0, 1.0):
        memory = ForceMemory(ForceHistory.begin(polynomial(times[0], 2)))
        for n in (1, 2):
            value = polynomial(times[n], 2) + error * (n == 2 - at_end)
            memory.take(value, 1e-4, 1e-4, 2, at_end=False)
        newest, elapsed = (times[2] + step, step) if at_end else (times[3], 1e-4)
        curve = memory.take(polynomial(newest, 2).ravel(), elapsed, step, 2, at_end=at_end)
        curves.append(curve.copy())
    assert np.array_equal(*curves)
    start = times[2] if at_end else times[3]
    expected = polynomial(start, 2).ravel(), polynomial(start + step, 2).ravel()
    assert curves[0][0] == pytest.approx(expected[0])
    if at_end:
        assert curves[0][1] == pytest.approx(expected[1])
