"""Coupled eigenmodes against a dense eigenproblem, the time domain and limits."""

import numpy as np
import pytest
from dense_track import dense_track
from rail_quantities import ParameterError, with_values
from slab_track import HD, TrackError
from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC
from slab_track.frequency import (
    WHEELSET_ON_PRIMARY,
    CoupledSystem,
    Wheelset,
    coupled_modes,
    hertz_stiffness,
    middle,
    receptance,
)

MIDDLE = middle(HD)


def dense_eigenvalues(p, wheelset, place, contact):
    """All eigenvalues and state vectors of rails, slabs, one wheelset and its frame.

    Coordinates: those of the dense track, bounce and roll of the wheelset, of the frame.
    """
    track = dense_track(p)
    n, b = track.stiffness.shape[0], 0.5 * p.contact.rolling_circle_distance
    rows = np.zeros((2, n + 4))
    rows[:, :n] = -track.wheel_rows(np.array([place]))
    rows[:, n] = 1.0
    rows[:, n + 1] = -b, b
    boxes = np.zeros((2, n + 4))
    boxes[:, n], boxes[:, n + 2] = 1.0, -1.0
    boxes[0, n + 1], boxes[1, n + 1] = np.array([-1, 1]) * wheelset.primary_half_span
    boxes[:, n + 3] = -boxes[:, n + 1]
    mass = np.ones(n + 4)
    mass[n:] = (
        wheelset.mass, wheelset.roll_inertia, wheelset.frame_mass, wheelset.frame_roll_inertia,
    )  # fmt: skip
    pad = ((0, 4), (0, 4))
    stiffness = np.pad(track.stiffness, pad) + contact * rows.T @ rows
    damping = np.pad(track.damping, pad)
    for box in boxes:
        stiffness += wheelset.primary_stiffness * np.outer(box, box)
        damping += wheelset.primary_damping * np.outer(box, box)
    size = n + 4
    state = np.block(
        [
            [np.zeros((size, size)), np.eye(size)],
            [-stiffness / mass[:, None], -damping / mass[:, None]],
        ]
    )
    values, vectors = np.linalg.eig(state)
    return values, vectors[:size]


def test_eigenvalues_and_shapes_of_the_dense_eigenproblem():
    settings = {
        "window.slab_count": 3,
        "rail.mode_count": 40,
        "slab.mode_count": 12,
        "rail.residual_compliance": False,
        "slab.residual_compliance": False,
    }
    p, place = with_values(HD, settings), 7.1
    contact = hertz_stiffness(p)
    values, vectors = dense_eigenvalues(p, WHEELSET_ON_PRIMARY, place, contact)
    rail = dense_track(p).wheel_rows(np.array([6.0, 7.1, 8.5]))
    for symmetry in (SYMMETRIC, ANTISYMMETRIC):
        (mode,) = coupled_modes(p, WHEELSET_ON_PRIMARY, [place], symmetry=symmetry)
        nearest = np.argmin(np.abs(values - mode.eigenvalue))
        assert values[nearest] == pytest.approx(mode.eigenvalue, rel=1e-8)
        shape = vectors[:, nearest]
        right = rail[3:] @ shape[: rail.shape[1]]
        wheel = shape[-4] + 0.5 * p.contact.rolling_circle_distance * shape[-3]
        found = np.interp([6.0, 7.1, 8.5], mode.rail_position, mode.rail)
        # The rail is drawn by chords of 8 cm.
        assert found == pytest.approx(right / wheel, abs=2e-3)
        assert mode.damping_ratio > 0.05


def test_shapes_keep_the_balance_of_forces():
    (mode,) = coupled_modes(HD, Wheelset(), [MIDDLE.fastener])
    s = mode.eigenvalue
    # Wheel: inertia; contact: Hertz spring; fastener: rail minus slab.
    assert -mode.contact_force[0] == pytest.approx(940.5 * s**2 * mode.wheel[0], rel=1e-9)
    under = mode.wheel[0] - mode.contact_force[0] / hertz_stiffness(HD)
    at = np.argmin(np.abs(mode.rail_position - MIDDLE.fastener))
    assert mode.rail[at] == pytest.approx(under, rel=1e-8)
    fasteners = (np.arange(HD.fastener_count) + 0.5) * HD.fastener.spacing
    rail = mode.rail[np.round(fasteners / HD.fastener.spacing * 8).astype(int)]
    assert rail - mode.seat == pytest.approx(mode.fastener, abs=1e-9)
    slab = np.argmax(np.abs(mode.slab[0]).max(axis=1))
    assert slab == HD.window.slab_count // 2
    assert mode.wheel[0] == pytest.approx(1.0)
    assert np.abs(mode.rail).max() < 1.0


def test_forced_response_peaks_at_the_mode():
    p = with_values(HD, {"fastener.vertical_stiffness": 140e6, "fastener.vertical_damping": 10e3})
    (mode,) = coupled_modes(p, Wheelset(), [MIDDLE.mid_bay])
    f = np.linspace(0.93, 1.07, 281) * mode.natural_frequency
    rail = receptance(p, f, [MIDDLE.mid_bay])
    # Wheel on both rails alike: mass, Hertz spring and track in series.
    track = (rail.same_rail + rail.other_rail)[:, 0, 0] + 1.0 / hertz_stiffness(p)
    wheel = 1.0 / (-((2.0 * np.pi * f) ** 2) * 940.5 + 1.0 / track)
    best = np.argmax(np.abs(wheel))
    assert f[best] == pytest.approx(mode.natural_frequency, rel=3e-3)
    half = f[np.abs(wheel) >= np.abs(wheel[best]) / np.sqrt(2.0)]
    width = (half[-1] - half[0]) / (2.0 * f[best])
    assert width == pytest.approx(mode.damping_ratio, rel=0.1)


def test_heavy_wheel_on_a_stiff_hinged_beam():
    """Fasteners as good as absent: beam between hinges with a mass in its middle."""
    p = with_values(
        HD,
        {
            "window.slab_count": 3,
            "rail.youngs_modulus": 2e15,
            "rail.shear_modulus": 8e14,
            "rail.mode_count": 200,
            "fastener.vertical_stiffness": 1e5,
            "fastener.vertical_damping": 0.0,
            "slab_support.vertical_stiffness": 1e14,
        },
    )
    length = p.window_length
    (mode,) = coupled_modes(
        p, Wheelset(mass=2e6), [0.5 * length], contact_stiffness=np.inf, guess=0.5
    )
    # Static shape of the hinged beam under its middle; the fasteners add little to it.
    bending = p.rail.youngs_modulus * p.rail.vertical_second_moment
    shear = p.rail.vertical_shear_coefficient * p.rail.shear_modulus * p.rail.area
    stiffness = 1.0 / (length**3 / (48.0 * bending) + length / (4.0 * shear))
    stiffness += 1e5 / p.fastener.spacing * length / 2.0
    wanted = np.sqrt(stiffness / (1e6 + 0.5 * length * 60.9)) / (2.0 * np.pi)
    assert mode.natural_frequency == pytest.approx(wanted, rel=1e-3)


def test_four_wheelsets_have_four_modes():
    places = MIDDLE.mid_bay + np.array([10.15, 7.65, -7.65, -10.15])
    modes = coupled_modes(HD, Wheelset(), places)
    (alone,) = coupled_modes(HD, Wheelset(), places[:1])
    frequencies = [mode.natural_frequency for mode in modes]
    assert frequencies == sorted(frequencies)
    assert len({round(f, 9) for f in frequencies}) == 4
    # Wheelsets of a bogie feel each other through the rail; those of two bogies hardly.
    assert frequencies[0] < alone.natural_frequency < frequencies[3]
    for mode in modes:
        system = CoupledSystem(HD, Wheelset(), places)
        matrix = system.matrix(mode.eigenvalue)
        residual = matrix @ mode.contact_force
        assert np.abs(residual).max() < 1e-9 * np.abs(matrix).max() * abs(mode.contact_force).max()


def test_search_that_finds_nothing_says_so():
    with pytest.raises(
        TrackError, match=r"near 100000 Hz in 60 steps; start the search at another"
    ):
        coupled_modes(HD, Wheelset(), [MIDDLE.mid_bay], guess=1e5)


def test_a_wheelset_without_mass_is_refused():
    with pytest.raises(ParameterError, match=r"wheelset\.mass = 0.*greater than 0"):
        Wheelset(mass=0.0)
