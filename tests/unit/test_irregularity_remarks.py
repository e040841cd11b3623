"""Fade-in of random part and file, a start without it, and what is said about both."""

import numpy as np
import pytest
from slab_track.irregularity import (
    CosineParameters,
    FileParameters,
    Irregularity,
    IrregularityParameters,
    RailJointParameters,
)

DISTANCE = np.arange(0.0, 80.01, 0.05)
WHEELSETS = np.array([0.0, -2.5, -17.8, -20.3])


def dip(centre, depth, length=3.0):
    """Full cosine wave, m."""
    inside = np.abs(DISTANCE - centre) < 0.5 * length
    wave = 0.5 * depth * (1.0 + np.cos(2.0 * np.pi * (DISTANCE - centre) / length))
    return np.where(inside, wave, 0.0)


@pytest.fixture
def made(tmp_path):
    """Return a function that makes an irregularity from columns of a file."""

    def make(columns, *, position=0.0, **values):
        path = tmp_path / "line.csv"
        table = np.column_stack([DISTANCE, *columns.values()])
        header = ",".join(["distance", *columns])
        np.savetxt(path, table, delimiter=",", header=header, comments="")
        file = FileParameters(path=str(path), position=position)
        return Irregularity(IrregularityParameters(file=file, **values))

    return make


def test_a_dip_in_the_ramp_is_remarked_with_what_is_left_of_it(made):
    irregularity = made({"level": dip(8.0, 2e-3)})
    (text,) = irregularity.remarks
    left = irregularity.evaluate([8.0])[0][0, 0, 0] / 2e-3
    assert left == pytest.approx(0.31744)  # t^3 (10 - 15 t + 6 t^2), t = 0.4
    assert "vertical excursion of 2 mm at 8 m" in text
    assert "ramp from 0 to 20 m" in text
    assert "31.7 % of it is left" in text
    assert "irregularity.ramp_length = 0" in text
    assert "irregularity.file.position" in text


def test_a_dip_behind_the_ramp_passes(made):
    assert made({"level": dip(30.0, 2e-3)}).remarks == ()
    assert made({"level": dip(8.0, 2e-3)}, ramp_length=5.0).remarks == ()
    assert made({"level": dip(8.0, 2e-3)}, position=20.0).remarks == ()
    assert made({"level": dip(8.0, 2e-3) + dip(40.0, -3e-3)}).remarks == ()


def test_a_steep_place_in_the_ramp_is_remarked_where_the_excursion_is_elsewhere(made):
    (text,) = made({"level": dip(50.0, 5e-3, 60.0) + dip(6.0, 5e-4, 0.5)}).remarks
    assert "vertical slope of" in text
    assert "mm/m at 6." in text or "mm/m at 5." in text


def test_directions_are_looked_at_apart_and_offsets_do_not_count(made):
    columns = {"level": dip(40.0, 4e-3) + 10e-3, "alignment": dip(10.0, 1e-3)}
    (text,) = made(columns).remarks
    assert "lateral excursion of 1 mm at 10 m" in text


def test_without_a_ramp_a_file_is_there_in_full_and_begins_smoothly(made):
    """Nothing jumps, neither at the start nor at the first row of a file that is not zero there."""
    irregularity = made({"level": dip(8.0, 2e-3) + 1e-3}, ramp_length=0.0)
    assert irregularity.remarks == ()
    step = 2.0**-8
    x = np.arange(-30.0, 30.0, step)
    offsets, slopes = irregularity.evaluate(x)
    assert np.interp(8.0, x, offsets[:, 0, 0]) == pytest.approx(3e-3, rel=1e-6)
    assert irregularity.evaluate([0.0, -10.0])[0][:, 1, 0] == pytest.approx([1e-3, 0.5e-3])
    assert np.abs(np.diff(offsets, axis=0)).max() < 1.01 * step * np.pi * 2e-3 / 3.0
    assert np.abs(np.diff(slopes, axis=0)).max() < 1.2 * step * 2.0 * np.pi**2 * 2e-3 / 9.0


def test_without_a_ramp_the_random_part_is_there_before_the_start():
    x = np.linspace(-200.0, 200.0, 999)
    parameters = IrregularityParameters(spectrum="german_low", ramp_length=0.0)
    ramped = Irregularity(parameters.replace(start=-300.0, ramp_length=20.0))
    for found, wanted in zip(Irregularity(parameters).evaluate(x), ramped.evaluate(x), strict=True):
        assert np.array_equal(found, wanted)
    (text,) = Irregularity(parameters.replace(start=50.0)).remarks
    assert "irregularity.start = 50 m has no effect" in text


def test_a_start_on_the_irregularity_is_remarked(made):
    line = {"level": dip(8.0, 2e-3) + 1e-3 + 2e-4 * DISTANCE}
    assert made(line).start_remarks(WHEELSETS) == ()
    (text,) = made(line, ramp_length=0.0).start_remarks(WHEELSETS)
    assert "starts on the irregularity: up to 1 mm under the wheels" in text
    assert made({"level": dip(8.0, 2e-3)}, ramp_length=0.0).start_remarks(WHEELSETS) == ()
    cosine = IrregularityParameters(cosine=CosineParameters(side="left", position=-2.3))
    assert len(Irregularity(cosine).start_remarks(WHEELSETS)) == 1


def test_a_joint_behind_all_wheels_is_remarked():
    joint = RailJointParameters(side="both", position=12.58)
    irregularity = Irregularity(IrregularityParameters(rail_joint=joint))
    assert irregularity.start_remarks(WHEELSETS) == ()
    (text,) = irregularity.start_remarks(WHEELSETS + 100.0)
    assert "irregularity.rail_joint.position = 12.58 m is behind the last wheelset" in text
    repeated = IrregularityParameters(rail_joint=joint.replace(repeat_distance=25.0))
    assert Irregularity(repeated).start_remarks(WHEELSETS + 100.0) == ()


def test_the_fade_in_is_said_where_there_is_one(made):
    text = "Fade-in of the file of the irregularity: from 5 m to full size at 25 m"
    assert text in made({"level": dip(30.0, 1e-3)}, start=5.0).fade_in
    random = IrregularityParameters(spectrum="german_low")
    assert (
        "Fade-in of the random part of the irregularity: from 0 m" in Irregularity(random).fade_in
    )
    assert Irregularity(random.replace(ramp_length=0.0)).fade_in == ""
    assert Irregularity(IrregularityParameters()).fade_in == ""
