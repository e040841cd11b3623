"""Steady state of wheel force and axle-box acceleration against the independent FE reference.

The pinned amplitudes come from ``reference_fe`` (other discretisation, other integrator);
the golden file names the command that regenerates them.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from pair import SingleWheelset, WholeVehicle, run_staggered
from rail_vehicle import VehicleModel, VehicleParameters
from reference_fe import ReferenceTrack, SingleWheel, band_limited_amplitude, simulate
from slab_track import TrackModel, TrackParameters
from slab_track.contact import ContactParameters
from slab_track.parameters import Fastener, Rail

VERTICAL = ContactParameters(model="vertical")
"""The reference knows eq. (1) only."""

GOLDEN = Path(__file__).parents[1] / "golden" / "steady_state_amplitudes.json"
CASES = json.loads(GOLDEN.read_text())["cases"]
RESONANCES = json.loads(GOLDEN.read_text())["resonance"]


def _name(case):
    return "{vehicle}-{speed_kmh:g}-{pad_stiffness:.3g}-{pad_damping:.3g}".format(**case)


def _run(case, distance, **rail):
    speed = case["speed_kmh"] / 3.6
    single = case["vehicle"] == "single_wheel"
    parameters = TrackParameters(
        contact=VERTICAL,
        rail=Rail(**rail),
        fastener=Fastener(
            vertical_stiffness=case["pad_stiffness"], vertical_damping=case["pad_damping"]
        ),
        wheelset_count=1 if single else 4,
    )
    if single:
        vehicle = SingleWheelset(mass=1881.0, load=parameters.static_wheel_load, speed=speed)
    else:
        vehicle = WholeVehicle(VehicleModel(VehicleParameters(speed=speed)))
    history = run_staggered(
        TrackModel(parameters), vehicle, distance=distance, speed=speed, step=1e-4
    )
    return history, parameters.pitch / speed


def _compare(case, distance, tolerance, **rail):
    history, period = _run(case, distance, **rail)
    force = band_limited_amplitude(history.time, history.normal_force[:, :, 0], window=period)
    box = band_limited_amplitude(history.time, history.acceleration, window=period)
    np.testing.assert_allclose(force, case["wheel_force_amplitude"], rtol=tolerance)
    np.testing.assert_allclose(box, case["wheelset_acceleration_amplitude"], rtol=tolerance)


QUICK = {
    ("single_wheel", 300.0, 40e6),
    ("single_wheel", 170.0, 140e6),
    ("vehicle", 300.0, 40e6),
    ("vehicle", 200.0, 140e6),
    ("vehicle", 170.0, 140e6),
}


def _quick(case):
    chosen = (case["vehicle"], case["speed_kmh"], case["pad_stiffness"]) in QUICK
    return chosen and case["pad_damping"] > 2e4 and case["steady"]


@pytest.mark.parametrize("case", [c for c in CASES if _quick(c)], ids=_name)
def test_amplitudes_below_500_hz(case):
    _compare(case, 50.32, 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("case", [c for c in CASES if c["steady"] and not _quick(c)], ids=_name)
def test_all_amplitudes_below_500_hz(case):
    # On lightly damped pads the start takes longer to die out.
    _compare(case, 50.32 if case["pad_damping"] > 2e4 else 120.768, 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("wanted", RESONANCES, ids=lambda case: f"{case['pad_stiffness']:.3g}")
def test_speed_of_the_largest_acceleration(wanted):
    """Within 1 km/h, by the parabola through the three highest of five speeds."""
    expected = wanted["resonance_speed_kmh"]
    speeds = expected + np.arange(-9.0, 10.0, 4.0)  # the peak between two of them
    values = []
    for speed in speeds:
        history, period = _run({**wanted, "vehicle": "single_wheel", "speed_kmh": speed}, 50.32)
        amplitude = band_limited_amplitude(history.time, history.acceleration, window=period)
        values.append(float(amplitude[0]))
    top = int(np.argmax(values))
    assert 0 < top < len(values) - 1
    near = np.polynomial.Polynomial.fit(speeds[top - 1 : top + 2], values[top - 1 : top + 2], 2)
    assert float(near.deriv().roots()[0]) == pytest.approx(expected, abs=1.0)
    assert max(values) == pytest.approx(wanted["wheelset_acceleration_amplitude"], rel=0.02)


def test_plain_modes_are_short_of_the_reference():
    """200 plain modes, the article's choice, miss more than a fifth of the amplitude."""
    case = next(c for c in CASES if c["vehicle"] == "single_wheel" and c["speed_kmh"] == 300.0)
    history, period = _run(case, 40.256, mode_count=200, residual_compliance=False)
    found = band_limited_amplitude(history.time, history.normal_force[:, :, 0], window=period)
    assert found[0] < 0.8 * case["wheel_force_amplitude"][0]


def test_force_history_follows_the_reference_point_by_point():
    """Not only amplitudes: the curve below 500 Hz, and its steep fall at each fastener."""
    speed, distance = 300 / 3.6, 20.128
    reference = simulate(
        ReferenceTrack(rail_elements_per_bay=16), SingleWheel(), speed, distance, step=2.5e-5
    )
    parameters = TrackParameters(wheelset_count=1, contact=VERTICAL)
    vehicle = SingleWheelset(mass=1881.0, load=parameters.static_wheel_load, speed=speed)
    history = run_staggered(
        TrackModel(parameters), vehicle, distance=distance, speed=speed, step=1e-4
    )
    found = history.normal_force[:, 0, 0]
    expected = np.interp(history.time, reference.time, reference.wheel_force[:, 0, 0])
    half = 0.5 * np.ptp(expected[history.time > 5.0 / speed])
    count = round(2 * parameters.pitch / speed / 1e-4)
    spectrum = np.fft.rfft((found - expected)[-count:])
    spectrum[np.fft.rfftfreq(count, 1e-4) > 500.0] = 0.0
    assert np.max(np.abs(np.fft.irfft(spectrum, count))) < 0.02 * half
    # Above 500 Hz the elements' own ripple of the reference remains.
    assert np.sqrt(np.mean((found - expected)[-count:] ** 2)) < 0.06 * half
