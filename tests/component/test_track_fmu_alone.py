"""The track FMU without a vehicle, in ``fmpy.simulate_fmu``."""

import numpy as np
import pytest
from fmu_probes import LOAD, PITCH, SPEED, STEP, STEPS_PER_BAY, rolling_inputs, simulate

COUNT = 32 * STEPS_PER_BAY  # four slab lengths
SLAB = 8 * STEPS_PER_BAY  # steps
WHEELS = [f"wheelset[{i}].{side}.normal_force" for i in range(1, 5) for side in ("left", "right")]
WINDOW = ["window.slide_count", "window.start_position"]
WITHOUT_SLIDES = {"window.method": "moving_mass", "window.slab_count": 20}
"""A window that stays: as fine as the default, and long enough to keep its ends away."""


def roll(fmus, *, velocities=True, **parameters):
    """Roll wheelsets of constant height along the track; return (time, wheel) forces, window."""
    values = {name.replace("__", "."): value for name, value in parameters.items()}
    result = fmus.call(
        simulate,
        fmus.track,
        STEP,
        COUNT,
        input=rolling_inputs(COUNT, velocities=velocities),
        output=WHEELS + WINDOW,
        start_values=values,
    )
    return np.stack([result[name] for name in WHEELS], axis=1), result


@pytest.fixture(scope="module")
def rolled(fmus):
    return roll(fmus)


def test_window_slides_with_the_wheels(rolled):
    force, result = rolled
    slides = np.flatnonzero(np.diff(result["window.slide_count"]))
    assert COUNT * STEP * SPEED > 12.0
    assert len(slides) == result["window.slide_count"][-1] == 4
    assert np.diff(result["window.start_position"])[slides] == pytest.approx(PITCH, abs=1e-9)
    assert np.isfinite(force).all()


def test_forces_are_those_of_the_bays_and_slabs(rolled):
    force, _ = rolled
    last, before = force[-SLAB:], force[-2 * SLAB : -SLAB]
    # Two slides, of at most 0.01 % of the static load each, lie between.
    assert np.abs(last - before).max() < 2e-4 * LOAD
    swing = 0.5 * np.ptp(last, axis=0)
    assert (swing > 0.01 * LOAD).all()
    lines = np.abs(np.fft.rfft(last - last.mean(axis=0), axis=0))
    assert (np.argmax(lines, axis=0) == 8).all()  # eight bays in a slab
    bays = last.reshape(8, STEPS_PER_BAY, -1)
    # The ends of the slabs make bays differ a little.
    assert np.ptp(bays, axis=0).max() < 0.15 * swing.max()


def test_mean_force_is_near_the_static_load(rolled):
    """Held at the heights' mean at rest, and the rails give way a little less at 300 km/h."""
    force, _ = rolled
    assert force[-SLAB:].mean() == pytest.approx(LOAD, rel=0.01)
    assert force[-SLAB:].mean(axis=0) == pytest.approx(LOAD, rel=0.03)


def test_no_slide_is_felt(rolled, fmus):
    """Against a window that stays where it is."""
    force, _ = rolled
    staying, result = roll(fmus, **WITHOUT_SLIDES)
    assert result["window.slide_count"][-1] == 0
    assert np.abs(force - staying).max() < 1e-4 * LOAD


def test_positions_alone_are_enough(rolled, fmus):
    """A tool that leaves the velocities unconnected gets the same, after the first step's kick."""
    force, result = rolled
    alone, window = roll(fmus, velocities=False)
    assert (window["window.slide_count"] == result["window.slide_count"]).all()
    assert np.abs(alone - force)[-SLAB:].max() < 1e-3 * LOAD


SINGLE = {
    "wheelset_count": 1,
    "static_wheel_load": LOAD,
    "window.slab_count": 7,  # enough for one wheelset
    "rail.mode_count": 324,
}
DEFLECTION = [f"wheelset[1].{side}.rail_vertical_displacement" for side in ("left", "right")]


def stand(fmus, count, *, force=None, position=0.3, **parameters):
    """Let one wheelset stand, or forces on its rail heads; return the deflections (time, side)."""
    names = ["wheelset[1].longitudinal_position"]
    values = [position]
    if force is not None:
        names += [f"rail_head[1].{side}.vertical_force" for side in ("left", "right")]
        values += list(force)
    inputs = np.zeros(2, dtype=[(name, float) for name in ["time", *names]])
    inputs["time"] = 0.0, 10.0
    for name, value in zip(names, values, strict=True):
        inputs[name] = value
    start = SINGLE | parameters
    result = fmus.call(
        simulate, fmus.track, 1e-4, count, input=inputs, output=DEFLECTION, start_values=start
    )
    return np.stack([result[name] for name in DEFLECTION], axis=1)


@pytest.fixture(scope="module")
def static_deflection(fmus):
    """Deflection that the contact interface starts with, m."""
    left, right = stand(fmus, 1)[0]
    assert left == pytest.approx(right, rel=1e-12)
    assert 0.3e-3 < left < 1.5e-3  # 69.21 kN on a rail on pads of 40 MN/m
    return left


def test_applied_static_force_keeps_the_rails_at_rest(fmus, static_deflection):
    deflection = stand(fmus, 1000, force=(LOAD, LOAD), interface="applied_force")
    assert deflection == pytest.approx(static_deflection, rel=1e-6)


def test_applied_force_takes_free_rails_to_the_static_deflection(fmus, static_deflection):
    """From no load at all; and half the force deflects half, at each instant."""
    free = {"interface": "applied_force", "static_wheel_load": 0.0}
    deflection = stand(fmus, 2500, force=(LOAD, LOAD), **free)
    assert deflection[0] == pytest.approx(0.0, abs=1e-12)
    assert deflection[-250:] == pytest.approx(static_deflection, rel=1e-3)
    half = stand(fmus, 500, force=(0.5 * LOAD, 0.5 * LOAD), **free)
    assert half == pytest.approx(0.5 * deflection[:501], abs=1e-9)


def test_profiles_are_there_when_read(fmus):
    """Point 25 is at the leading wheelset: 6 m ahead less 24 times 0.25 m."""
    under = "wheelset[1].left.rail_vertical_displacement"
    profile = [f"rail_profile.left.vertical_displacement[{k}]" for k in (25, 85, 1)]
    slab = "slab_profile.right.vertical_displacement[25]"
    result = fmus.call(
        simulate,
        fmus.track,
        STEP,
        50,
        input=rolling_inputs(50),
        output=[under, *profile, slab],
        start_values={"rail_profile.enabled": True},
    )
    assert result[profile[0]] == pytest.approx(result[under], rel=2e-3)
    assert np.ptp(result[profile[0]][1:]) > 1e-6  # it follows the steps
    assert np.abs(result[profile[2]]).max() < 0.1 * result[under].max()  # 6 m ahead
    assert (result[slab] > 1e-6).all()
    assert (result[slab] < result[under]).all()


def test_profiles_cost_nothing_unless_wanted(fmus):
    """Tools that read all variables at every step must not wait for them."""
    point = "rail_profile.left.vertical_displacement[25]"
    result = fmus.call(
        simulate, fmus.track, STEP, 3, input=rolling_inputs(3), output=[point], start_values={}
    )
    assert (result[point] == 0.0).all()


def test_forces_on_the_rails_are_those_on_the_wheelsets_turned_round(fmus):
    """Action and reaction: the wheelset receives minus the sum of both rails' forces."""
    names = {
        sum_: [f"wheelset[2].{side}.{one}" for side in ("left", "right")]
        for sum_, one in (
            ("wheelset[2].contact.lateral_force", "guiding_force"),
            ("wheelset[2].contact.vertical_force", "vertical_wheel_force"),
        )
    }
    output = [name for sum_, pair in names.items() for name in (sum_, *pair)]
    result = fmus.call(
        simulate,
        fmus.track,
        STEP,
        50,
        input=rolling_inputs(50),
        output=output,
        start_values={"wheelset[2].lateral_displacement": 8e-3},  # towards the flange
    )
    for sum_, pair in names.items():
        total = result[pair[0]] + result[pair[1]]
        np.testing.assert_allclose(total, -result[sum_], rtol=1e-9, atol=1e-3)
        assert np.abs(result[sum_]).max() > 1e3
