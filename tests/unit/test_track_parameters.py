"""Parameters of the track refuse nonsense and say what to do."""

import numpy as np
import pytest
from rail_quantities import ParameterError, UnknownParameterError, flatten, with_values
from slab_track import HD, ZX, TrackError, TrackModel, TrackParameters
from slab_track.kernels.motion import extrapolate
from slab_track.parameters import Window
from slab_track.presets import PAPER
from slab_track.window import place_window


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("fastener.vertical_stiffness", -1.0, r"vertical_stiffness = -1\.0.*greater than 0"),
        ("rail.mode_count", 2, r"rail\.mode_count = 2.*at least 8"),
        ("rail.mode_count", 100.5, "whole number"),
        ("slab.poisson_ratio", 0.5, r"slab\.poisson_ratio = 0\.5.*less than 0\.5"),
        ("slab_support.basis", "per_mile", "must be one of per_bay, per_seat"),
        ("window.method", "flying", "must be one of sliding"),
        ("rail.density", float("nan"), "finite number"),
        ("rail.density", "steel", "finite number"),
        ("slab.length", 6.0, r"slab\.length = 6\.0.*at most the 5\.032 m"),
        ("slab.gap", 0.7, r"slab\.gap = 0\.7.*less than the 0\.629 m"),
        ("slab.width", 1.2, r"slab\.width = 1\.2.*more than the 1\.493 m"),
        ("window.sample_count", 200, r"window\.sample_count = 200.*more than rail\.mode_count"),
        ("window.slab_count", 1, "at least 3"),
        ("rail.residual_compliance", 1, "true or false"),
    ],
)
def test_bad_values_are_refused_by_name(name, value, message):
    with pytest.raises(ParameterError, match=message):
        with_values(TrackParameters(), {name: value})


def test_misspelt_name_gets_the_nearest_right_one():
    with pytest.raises(UnknownParameterError, match=r"did you mean fastener\.vertical_stiffness"):
        with_values(TrackParameters(), {"fastener.verticl_stiffness": 1.0})


def test_lines_of_the_article():
    assert HD.pitch == pytest.approx(5.032)
    assert HD.slab_length == pytest.approx(4.962)
    assert PAPER.window_length == pytest.approx(65.416)
    assert ZX.pitch == pytest.approx(5.67)
    assert ZX.slab_length == pytest.approx(5.6)


def test_modes_follow_from_the_length_of_the_window():
    """All waves longer than 0.51 m, whatever the window: 2 l/0.51."""
    for slabs, count in ((13, 256), (16, 315), (51, 1006)):
        p = with_values(HD, {"window.slab_count": slabs})
        assert p.rail_mode_count == count
        assert p.sample_count > count
    assert with_values(HD, {"rail.mode_count": 77}).rail_mode_count == 77
    with pytest.raises(ParameterError, match=r"slab_count = 200.*11.*at most 4000"):
        with_values(HD, {"window.slab_count": 200, "fastener.spacing": 1.8})


def test_every_parameter_describes_itself():
    for name, (about, _) in flatten(TrackParameters()).items():
        assert about.description, name


def _motion(x, v=0.0):
    rows = np.zeros((len(x), 11))
    rows[:, 0], rows[:, 5] = x, v
    return rows


def test_vehicle_too_long_for_the_window():
    model = TrackModel(with_values(TrackParameters(), {"window.slab_count": 5}))
    with pytest.raises(TrackError, match=r"raise window\.slab_count"):
        model.initial_state(_motion([0.0, -2.5, -17.8, -20.3]))


def test_moving_mass_ends_before_the_wheel_leaves_the_window():
    parameters = with_values(
        TrackParameters(),
        {
            "window.method": "moving_mass",
            "wheelset_count": 1,
            "rail.mode_count": 60,
            "window.slab_count": 8,
        },
    )
    model = TrackModel(parameters)
    state = model.initial_state(_motion([0.0], 80.0))
    x = 0.0

    def step():
        nonlocal state, x
        state, _ = model.step(state, _motion([x], 80.0), 1e-2)
        x += 0.8

    window_end = state.window_start + parameters.window_length
    while x < window_end - 3.0 - 0.8:
        step()
    assert state.slide_count == 0
    with pytest.raises(TrackError, match=r"within 3 m of the ends.*window\.method = moving_mass"):
        step()


def test_offset_of_the_vehicle_must_leave_room_at_the_ends():
    model = TrackModel(
        with_values(TrackParameters(), {"window.vehicle_offset": 26.0, "rail.mode_count": 60})
    )
    with pytest.raises(TrackError, match=r"takes at most.*reduce window\.vehicle_offset"):
        model.initial_state(_motion([0.0, -2.5, -17.8, -20.3]))


def test_motion_must_be_finite():
    model = TrackModel(with_values(TrackParameters(), {"wheelset_count": 1, "rail.mode_count": 60}))
    state = model.initial_state(_motion([0.0]))
    with pytest.raises(TrackError, match="not a finite number"):
        model.step(state, _motion([np.nan]), 1e-4)


def test_history_reproduces_a_cubic_and_falls_back_to_positions():
    def cubic(t):
        return np.array([1.0 + 2 * t - 3 * t**2 + 4 * t**3]), np.array([2 - 6 * t + 12 * t**2])

    def row(t, with_rate=True):
        motion = np.zeros((1, 11))
        motion[0, 2] = cubic(t)[0][0]
        motion[0, 7] = cubic(t)[1][0] if with_rate else 0.0
        return motion

    found = np.empty((1, 11))
    for tau in (0.05, 0.1):
        extrapolate(tau, 0.1, row(0.1), row(0.0), np.ones(5), found)
        assert found[0, 2] == pytest.approx(cubic(0.1 + tau)[0][0], rel=1e-12)
    extrapolate(0.1, 0.1, row(0.1, False), row(0.0, False), np.zeros(5), found)
    slope = (cubic(0.1)[0][0] - cubic(0.0)[0][0]) / 0.1
    assert found[0, 2] == pytest.approx(cubic(0.1)[0][0] + 0.1 * slope)


def test_level_contact_refuses_internal_steps_at_which_its_wheels_bounce():
    level = with_values(TrackParameters(), {"contact.model": "vertical"})
    with pytest.raises(ParameterError, match=r"maximum_step = 0\.0003.*at most 0\.0002 s"):
        with_values(level, {"integration.maximum_step": 3e-4})
    profiles = {"contact.model": "profiles", "integration.maximum_step": 3e-4}
    assert with_values(level, profiles).integration.maximum_step == 3e-4


@pytest.mark.parametrize("offset", [0.0, -3.0])
def test_wheels_keep_the_same_way_to_both_ends_at_the_worst_instants(offset):
    """But for the offset; and the window lies on whole slabs of the line."""
    p = TrackParameters(window=Window(vehicle_offset=offset))
    wheels = -np.array([0.0, 2.5, 17.8, 20.3])
    step = p.slide_length / 500.0
    rear, front = [], []
    for x in step * np.arange(1000) + 123.0:
        start = place_window(p, x + wheels)
        assert start / p.pitch == pytest.approx(round(start / p.pitch), abs=1e-9)
        rear.append(x + wheels[-1] - start)
        front.append(start + p.window_length - x)
    assert min(rear) - min(front) == pytest.approx(2.0 * offset, abs=2.0 * step)
    assert max(rear) - min(rear) == pytest.approx(p.slide_length, abs=2.0 * step)
