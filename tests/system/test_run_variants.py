"""``rail-cosim run`` away from the nominal case: resonance, other line, other vehicle."""

import numpy as np
import pytest
from runs import golden_amplitudes, run

REFERENCE_CONTACT = "track.contact.hertz_constant=4.221e-8"
"""At resonance 9 % of the contact's compliance are 3 % of the amplitude: take the reference's."""

HD_PITCH, ZX_PITCH = 8 * 0.629, 9 * 0.63


@pytest.fixture(scope="module")
def at_170(fmus, tmp_path_factory):
    """Wheel-force amplitudes at 170 km/h, (wheelset, side), by pad stiffness."""

    def amplitude(stiffness, slabs):
        folder = tmp_path_factory.mktemp("resonance")
        pads = f"--set=track.fastener.vertical_stiffness={stiffness}"
        options = ["--speed", 170, "--distance", slabs * HD_PITCH, pads]
        done = run(fmus, folder, *options, "--set", REFERENCE_CONTACT)
        assert done.data.attrs["track.fastener.vertical_stiffness"] == float(stiffness)
        return done.amplitude("normal_force", HD_PITCH)

    # At resonance the start takes longer to die away.
    return {40e6: amplitude("40e6", 5), 140e6: amplitude("140e6", 8)}


def test_stiff_pads_resonate_at_170(at_170):
    """The wheelset on its track passes sleepers near the resonance of the two (article, 4.2)."""
    assert (at_170[140e6] > 5.0 * at_170[40e6]).all()


@pytest.mark.parametrize("stiffness", [40e6, 140e6])
def test_amplitudes_are_those_of_the_finite_element_track(at_170, stiffness):
    golden = golden_amplitudes(170.0, stiffness)
    if golden is None:
        pytest.skip("tests/golden has no whole vehicle with these pads yet")
    expected, error = golden
    found = at_170[stiffness]
    assert found == pytest.approx(expected[:, None].repeat(2, axis=1), rel=0.01 + error)


def test_manchester_vehicle_on_the_zx_line(fmus, tmp_path):
    speed, distance = 200.0 / 3.6, 6 * ZX_PITCH
    options = ["--line", "ZX", "--vehicle", "manchester1", "--speed", 200, "--distance", distance]
    done = run(fmus, tmp_path, *options)
    about = done.data.attrs
    assert about["track.fastener.count_per_slab"] == 9
    assert about["track.slab.thickness"] == 0.2
    assert about["vehicle.car_body.mass"] == 32000.0
    load = (32000.0 + 2 * 2615.0 + 4 * 1813.0) * 9.81 / 8
    assert about["track.static_wheel_load"] == pytest.approx(load, rel=1e-12)
    force = done["normal_force"]
    assert np.isfinite(force).all()
    assert force.mean(axis=0) == pytest.approx(load, rel=1e-3)
    assert done.slides == pytest.approx(ZX_PITCH, abs=1e-9)
    # Periodic with the slabs of this line: nine bays of 0.63 m.
    way = done["distance"]
    last = np.linspace(distance - ZX_PITCH, distance, 9 * 40, endpoint=False)
    wheel = np.interp(last, way, force[:, 0, 0])
    before = np.interp(last - ZX_PITCH, way, force[:, 0, 0])
    assert np.abs(wheel - before).max() < 1e-3 * load
    lines = np.abs(np.fft.rfft(wheel - wheel.mean()))
    assert lines.argmax() == 9
    assert way[-1] == pytest.approx(distance, abs=speed * 1e-4)
