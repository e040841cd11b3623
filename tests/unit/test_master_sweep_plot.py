"""The picture of a sweep: what is drawn over which axis, with which unit, and what is not."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba
from rail_cosim import plot_sweep
from rail_cosim.errors import ParameterError
from rail_cosim.sweeps.plot import sweep_figure

SPEED = ("speed", [100.0, 200.0, 300.0], {"units": "km/h"})
STIFFNESS = "track.fastener.vertical_stiffness"


def sweep(values, dims, coords, name="normal_force_max", unit="N"):
    wheels = {"wheelset": [1, 2], "side": ["left", "right"]}
    of_points = np.asarray(values, float)
    spread = np.array([[0.0, -1.0], [-2.0, -3.0]])  # the first wheel has the largest value
    every = of_points[..., None, None] + spread
    return xr.Dataset(
        {
            name: ((*dims, "wheelset", "side"), every, {"units": unit}),
            "error": (dims, np.full(of_points.shape, "", dtype=object)),
            "steady": (dims, np.ones(of_points.shape)),
        },
        coords={**coords, **wheels},
    )


def test_over_one_axis_it_is_a_curve_of_the_largest_value():
    data = sweep([70e3, 80e3, 75e3], ("speed",), {"speed": SPEED})
    (axes,) = sweep_figure(data).axes
    (line,) = axes.lines
    np.testing.assert_allclose(line.get_xydata(), [[100, 70], [200, 80], [300, 75]])
    assert axes.get_xlabel() == "speed (km/h)"
    assert axes.get_ylabel() == "kN"
    assert axes.get_title("left") == "normal force max, largest of all wheels"


@pytest.mark.parametrize(
    ("name", "expected"),
    [("force_min", 7.0), ("force_mean", 8.5), ("force_dominant_frequency", 8.5), ("force_rms", 10)],
)
def test_of_a_minimum_the_smallest_and_of_a_mean_the_mean(name, expected):
    data = sweep([10.0, 10.0, 10.0], ("speed",), {"speed": SPEED}, name, "N")
    (axes,) = sweep_figure(data).axes
    np.testing.assert_allclose(axes.lines[0].get_ydata(), expected)


def test_over_two_axes_it_is_a_family_of_curves():
    coords = {"speed": SPEED, STIFFNESS: (STIFFNESS, [40e6, 140e6], {"units": "N/m"})}
    data = sweep(np.arange(6.0).reshape(3, 2) * 1e3, ("speed", STIFFNESS), coords)
    figure = sweep_figure(data)
    (axes,) = figure.axes
    np.testing.assert_allclose([line.get_ydata() for line in axes.lines], [[0, 2, 4], [1, 3, 5]])
    (legend,) = figure.legends
    assert legend.get_title().get_text() == f"{STIFFNESS} (MN/m)"
    assert [text.get_text() for text in legend.get_texts()] == ["40", "140"]


def test_an_axis_of_names_tells_the_curves_apart():
    data = sweep(np.ones((3, 9)), ("line", "speed"), {"line": ["HD", "ZX", "paper"]})
    data = data.assign_coords(speed=("speed", np.arange(9.0), {"units": "km/h"}))
    (axes,) = sweep_figure(data).axes
    assert [line.get_label() for line in axes.lines] == ["HD", "ZX", "paper"]


def test_over_two_long_axes_it_is_a_map_also_of_falling_values():
    values = np.arange(90.0).reshape(10, 9)
    coords = {
        "speed": ("speed", np.arange(10.0)[::-1] * 10, {"units": "km/h"}),
        STIFFNESS: (STIFFNESS, np.arange(1, 10) * 1e6, {"units": "N/m"}),
    }
    axes, bar = sweep_figure(sweep(values, ("speed", STIFFNESS), coords)).axes
    (mesh,) = axes.collections
    np.testing.assert_allclose(mesh.get_array(), values[::-1].T)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed (km/h)", f"{STIFFNESS} (MN/m)")
    assert bar.get_ylabel() == "N"


def test_single_points_are_sorted_by_the_axis_that_differs():
    coords = {"speed": ("point", [300.0, 100.0, 200.0], {"units": "km/h"})}
    data = sweep([3.0, 1.0, 2.0], ("point",), coords)
    (axes,) = sweep_figure(data).axes
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[100, 1], [200, 2], [300, 3]])


def test_points_that_differ_in_more_are_drawn_by_number():
    coords = {
        "speed": ("point", [300.0, 100.0], {"units": "km/h"}),
        "line": ("point", ["HD", "ZX"]),
    }
    (axes,) = sweep_figure(sweep([3.0, 1.0], ("point",), coords)).axes
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[1, 3], [2, 1]])
    assert axes.get_xlabel() == "number of the point"


def test_a_point_that_failed_is_a_gap():
    data = sweep([70e3, np.nan, 75e3], ("speed",), {"speed": SPEED}, "force_dominant_frequency")
    (axes,) = sweep_figure(data).axes
    assert np.isnan(axes.lines[0].get_ydata()).tolist() == [False, True, False]


def test_three_axes_are_refused_and_so_is_what_is_not_there():
    data = sweep(np.zeros((2, 2, 2)), ("a", "b", "c"), {})
    with pytest.raises(ParameterError, match="over 3 axes"):
        sweep_figure(data)
    data = sweep([1.0], ("speed",), {"speed": [100.0]})
    with pytest.raises(ParameterError, match="no such quantity; it has normal_force_max"):
        sweep_figure(data, ["normal_force_min"])


def test_it_is_written_as_its_ending_says(tmp_path):
    data = sweep([70e3, 80e3, 75e3], ("speed",), {"speed": SPEED})
    plot_sweep(data, tmp_path / "sweep.svg")
    assert "</svg>" in (tmp_path / "sweep.svg").read_text()
    with pytest.raises(ParameterError, match=r"must end in \.png"):
        plot_sweep(data, tmp_path / "sweep.doc")


def test_curves_have_colours_of_their_own():
    coords = {"speed": SPEED, "k": ("k", np.arange(5.0))}
    (axes,) = sweep_figure(sweep(np.zeros((3, 5)), ("speed", "k"), coords, "x", "m")).axes
    # Seven curves at most, so the longer axis, k, runs along and the speeds are the family.
    assert len({to_rgba(line.get_color()) for line in axes.lines}) == 3
