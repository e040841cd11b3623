"""Partners that go wrong: found in the step where they do, with time and place.

A wheelset on a short track is moved by a script, as a foreign vehicle would that diverges, jumps
or leaves the rails.
"""

import numpy as np
import pytest
from rail_quantities import with_values
from slab_track import TrackError, TrackModel, TrackParameters
from slab_track.motion import MOTION

SMALL = {"wheelset_count": 1, "window.slab_count": 8, "rail.mode_count": 60, "slab.mode_count": 6}
STEP, SPEED, RADIUS = 1e-4, 80.0, 0.43
FROM = 3
"""Step in which a value goes wrong."""


@pytest.fixture(scope="module")
def model():
    return TrackModel(with_values(TrackParameters(), SMALL))


def roll(model, script, steps):
    """Roll along as the script says; return the number of steps made, forces and the error."""
    row = np.zeros((1, 11))
    row[0, 0], row[0, 5], row[0, 10] = model.default_positions()[0], SPEED, -SPEED / RADIUS
    state, forces = model.initial_state(row), []
    for n in range(steps):
        motion = row.copy()
        motion[0, 0] += SPEED * STEP * n
        script(motion[0], n)
        try:
            state, outputs = model.step(state, motion, STEP)
        except TrackError as error:
            return n, np.array(forces), str(error)
        forces.append(outputs.normal_force.ravel())
    return steps, np.array(forces), ""


def suddenly(column, value):
    def script(row, n):
        if n >= FROM:
            row[column] = value

    return script


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", range(11), ids=MOTION)
def test_motion_that_is_no_number_is_refused_at_once(model, column, value):
    made, forces, why = roll(model, suddenly(column, value), 10)
    assert made == FROM
    assert "is not a finite number at t = 0.0003 s" in why
    assert np.isfinite(forces).all()


@pytest.mark.parametrize("value", [1e30, -1e30, 1e6])
@pytest.mark.parametrize("column", range(10), ids=MOTION[:10])
def test_motion_that_diverges_is_refused_at_once(model, column, value):
    """A spin of any size is possible: it ends in slip."""
    made, forces, why = roll(model, suddenly(column, value), 10)
    assert made == FROM
    assert "t = 0.0003 s" in why
    assert np.isfinite(forces).all()


def moving(column, rate):
    def script(row, n):
        row[column] += rate * STEP * n
        row[column + 5] += rate

    return script


LEAVING = {
    "climbing to the right": (moving(1, 1.0), "lateral displacement 20"),
    "climbing to the left": (moving(1, -1.0), "lateral displacement -20"),
    "rolling over": (moving(3, 5.0), "derailment"),
    "turning across": (moving(4, 10.0), "derailment"),
    "pressed into the rail": (moving(2, 3.0), "contact forces were not found"),
}


@pytest.mark.parametrize("case", LEAVING)
def test_leaving_the_rails_is_said_with_time_and_place(model, case):
    script, text = LEAVING[case]
    made, forces, why = roll(model, script, 400)
    assert 5 < made < 400
    assert np.isfinite(forces).all()
    assert "at t = 0.0" in why
    assert "wheelset 1 at " in why
    assert text in why


def test_a_growing_oscillation_ends_in_an_error_and_not_in_numbers(model):
    def script(row, n):
        t = STEP * n
        size = 1e-5 * np.exp(200.0 * t)
        row[2] += size * np.sin(600.0 * t)
        row[7] += size * (600.0 * np.cos(600.0 * t) + 200.0 * np.sin(600.0 * t))

    made, forces, why = roll(model, script, 1000)
    assert made < 1000
    assert "contact forces were not found" in why
    assert np.isfinite(forces).all()


def test_a_lifted_wheelset_is_no_error(model):
    made, forces, why = roll(model, moving(2, -0.5), 100)
    assert (made, why) == (100, "")
    assert forces[-1] == pytest.approx(0.0)


@pytest.mark.parametrize("way", [0.6, 10.0, 100.0, -0.6, -10.0, -100.0])
def test_jumps_along_the_line_are_refused_at_once(model, way):
    def script(row, n):
        row[0] += way * (n >= FROM)

    made, _, why = roll(model, script, 10)
    assert made == FROM
    assert f"{way + 0.008:g} m from where they were 0.0001 s before, but run at 80 m/s" in why


@pytest.mark.parametrize("way", [10.0, 100.0, -10.0, -100.0])
def test_without_velocities_the_window_is_the_limit_of_a_jump(model, way):
    def script(row, n):
        row[0] += way * (n >= FROM)
        row[5] = 0.0

    made, _, why = roll(model, script, 10)
    assert made in (FROM, FROM + 1)
    assert "the window" in why


def test_a_wheelset_inside_its_rails_is_refused_at_once(model):
    made, _, why = roll(model, suddenly(2, 0.31), 10)
    assert made == FROM
    assert "wheelset 1 is 0.31 m below where it rests" in why
    assert "more than 0.3 m, inside the rail" in why


def test_speed_may_go_through_zero_and_backwards(model):
    """With the force of a wheel at rest in between."""

    def script(row, n):
        t, brake = STEP * n, 4000.0
        row[0] += -0.5 * brake * t**2
        row[5] -= brake * t
        row[10] = -row[5] / RADIUS

    made, forces, why = roll(model, script, 400)
    assert (made, why) == (400, "")
    assert np.isfinite(forces).all()
    assert forces.mean() == pytest.approx(69e3, rel=0.05)


SOFT = {"rail.vertical_second_moment": 3.2e-11, "rail.vertical_shear_coefficient": 5.3e-7}


@pytest.mark.parametrize("name", SOFT)
def test_rails_that_carry_nothing_are_refused_at_the_start(name):
    """They sink by some 30 m, and a wheel would fly over the ditch with forces of zero."""
    model = TrackModel(with_values(TrackParameters(), {**SMALL, name: SOFT[name]}))
    row = np.zeros((1, 11))
    row[0, 0] = model.default_positions()[0]
    with pytest.raises(TrackError, match=r"static_wheel_load = .* N the rails move by [23]\d"):
        model.initial_state(row)


@pytest.mark.parametrize("contact", ["profiles", "vertical"])
def test_rails_that_are_no_number_do_not_pass_for_no_contact(contact):
    """No comparison is true for them, so a wheel seems to hang in the air."""
    model = TrackModel(with_values(TrackParameters(), {**SMALL, "contact.model": contact}))
    row = np.zeros((1, 11))
    row[0, 0], row[0, 5], row[0, 10] = model.default_positions()[0], SPEED, -SPEED / RADIUS
    state = model.initial_state(row)
    state.symmetric.rail[0, 0, 3] = np.nan
    with pytest.raises(TrackError, match=r"at t = 0 s, wheelset 1 at .* not found"):
        model.step(state, row, STEP)


@pytest.mark.parametrize("dt", [0.0, -1e-4, np.nan, np.inf, 1e3, 1e300])
def test_impossible_and_endless_steps_are_refused_at_once(model, dt):
    row = np.zeros((1, 11))
    row[0, 0] = model.default_positions()[0]
    with pytest.raises(TrackError, match=r"step size .* at most 1 s, 10000 internal steps"):
        model.step(model.initial_state(row), row, dt)
