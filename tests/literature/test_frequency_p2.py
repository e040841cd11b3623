"""P2 resonance of the article (eqs. (12)-(16), section 3.1.2), and pinned-pinned frequencies."""

import numpy as np
import pytest
from rail_quantities import with_values
from slab_track import HD
from slab_track.frequency import (
    WHEELSET_ON_PRIMARY,
    Wheelset,
    coupled_modes,
    middle,
    p2_formula,
    pinned_pinned_extremes,
    pinned_pinned_frequency,
    resonance_speed,
)

WINTER = with_values(HD, {"fastener.vertical_stiffness": 140e6})
HALF = 0.5 * 1881.0


@pytest.mark.parametrize(
    ("line", "printed", "table_2", "speed"), [(HD, 51.4, 50.5, 116.4), (WINTER, 83.1, 81.6, 188.2)]
)
def test_formula_gives_the_article_s_frequencies_with_a_bay_of_060(line, printed, table_2, speed):
    with_060 = p2_formula(line, HALF, spacing=0.60).frequency
    assert with_060 == pytest.approx(printed, abs=0.06)
    assert p2_formula(line, HALF).frequency == pytest.approx(table_2, abs=0.06)
    # The speeds are printed for these frequencies and the bay of Table 2.
    assert 3.6 * resonance_speed(with_060, 0.629) == pytest.approx(speed, rel=2e-3)


def test_printed_equation_12_has_the_wrong_dimension():
    found = p2_formula(HD, HALF)
    # Mass of a rail on a Winkler base by Rayleigh's quotient: 3 m_tr times a decay length.
    length = (HD.rail.youngs_modulus * HD.rail.vertical_second_moment / found.track_stiffness) ** (
        1 / 3
    )
    assert found.track_mass == pytest.approx(3.0 * 7860.0 * 7.745e-3 * length)
    printed = np.sqrt(found.track_stiffness / found.track_mass + HALF) / (2.0 * np.pi)
    assert printed > 2.0 * found.frequency


def test_coupled_mode_meets_the_formula_on_a_rigid_base():
    """As the formula has it: rigid contact, rigid slabs; its rail is only estimated."""
    p = with_values(HD, {"slab_support.vertical_stiffness": 1e16, "fastener.vertical_damping": 0.0})
    places = middle(p)
    found = [
        coupled_modes(p, Wheelset(), [x], contact_stiffness=np.inf)[0].natural_frequency
        for x in places
    ]
    # Shear makes the rail softer (Timoshenko 4.7 % more deflection), and the rail that moves
    # along is lighter than eq. (15) says.
    assert found == pytest.approx([p2_formula(p, HALF).frequency] * 2, rel=0.03)


def test_coupled_mode_of_the_track_lies_below_the_formula():
    """Hertz spring, slabs and shear make it softer; the stiffer the fasteners, the more."""
    below = []
    for line in (HD, WINTER):
        mode = coupled_modes(line, WHEELSET_ON_PRIMARY, [middle(line).mid_bay])[0]
        below.append(mode.natural_frequency / p2_formula(line, HALF).frequency)
        # Wheel and rail in phase, the slab nearly at rest (Fig. 10).
        under = mode.rail[np.argmax(np.abs(mode.rail))]
        assert abs(np.angle(under / mode.wheel[0])) < np.radians(5.0)
        assert np.abs(mode.slab).max() < 0.1
    assert 0.8 < below[1] < below[0] < 1.01


def test_damped_fasteners_damp_the_mode():
    def ratio(damping):
        line = with_values(WINTER, {"fastener.vertical_damping": damping})
        return coupled_modes(line, Wheelset(), [middle(line).mid_bay])[0].damping_ratio

    assert 0.0 < ratio(10e3) < 0.5 * ratio(52e3)


@pytest.mark.parametrize(("spacing", "wanted"), [(0.629, 1042.8), (0.600, 1126.7)])
def test_pinned_pinned_closed_form(spacing, wanted):
    line = with_values(HD, {"fastener.spacing": spacing})
    assert pinned_pinned_frequency(line) == pytest.approx(wanted, abs=0.1)


@pytest.mark.parametrize("spacing", [0.629, 0.600])
def test_receptance_has_peak_and_dip_at_the_pinned_pinned_frequency(spacing):
    line = with_values(HD, {"fastener.spacing": spacing, "fastener.vertical_damping": 1000.0})
    wanted = pinned_pinned_frequency(line)
    found = pinned_pinned_extremes(line)
    assert found.peak == pytest.approx(wanted, rel=1e-3)
    assert wanted < found.dip < 1.012 * wanted
