"""Animations: when frames are recorded, where things stand in them, what is refused."""

import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image
from rail_cosim.animation import Film, check_animation, check_track, ffmpeg, write_animation
from rail_cosim.animation.drawing import Stage, default_exaggeration
from rail_cosim.animation.film import FRAME_RATE
from rail_cosim.errors import ParameterError, ResultsError
from rail_cosim.options import RunOptions
from rail_cosim.runner import Quiet
from rail_cosim.slave import Variable

SPEED, STEP, POINTS, RADIUS = 80.0, 1e-4, 121, 0.46
PLACES = np.array([0.0, -2.5, -17.8, -20.3])
OFFSETS = 6.0 - 0.25 * np.arange(POINTS)


def sunk(offsets, depth=1e-3):
    """Return a dip of the rails of 1 mm under every wheel."""
    return depth * np.exp(-(((offsets[:, None] - PLACES) / 0.8) ** 2)).sum(axis=1)


class FakeVector:
    def __init__(self, slave, names):
        self.slave, self.names, self.values = slave, tuple(names), np.zeros(len(names))

    def read(self, count=None):
        self.values[:] = [self.slave.values[name] for name in self.names]


class FakeSlave:
    """A slave whose values a test sets."""

    def __init__(self, name, values):
        self.name, self.values = name, values

    @property
    def variables(self):
        return {name: Variable(name=name) for name in self.values}

    def get(self, names):
        return {name: self.values[name] for name in names}

    def vector(self, names, kind="real"):
        return FakeVector(self, names)


def pair(*, bogies=True):
    track = {
        "fastener.spacing": 0.629,
        "fastener.count_per_slab": 8,
        "slab.gap": 0.07,
        "window.slab_count": 16,
        "window.start_position": -40.256,
        "rail_profile.first_offset": 6.0,
        "rail_profile.spacing": 0.25,
    }
    for k, (rail, slab) in enumerate(zip(sunk(OFFSETS), sunk(OFFSETS, 2e-5), strict=True), 1):
        track[f"rail_profile.left.vertical_displacement[{k}]"] = rail
        track[f"slab_profile.left.vertical_displacement[{k}]"] = slab
    vehicle = {"wheelset.radius": RADIUS}
    if bogies:
        vehicle |= {"bogie.half_wheelbase": 1.25, "car_body.half_bogie_spacing": 8.9}
        bodies = ("bogie[1]", "bogie[2]", "car_body")
        for one in bodies:
            vehicle |= {f"{one}.vertical_displacement": 0.0, f"{one}.pitch_angle": 0.0}
    for i, place in enumerate(PLACES, 1):
        track[f"wheelset[{i}].left.normal_force"] = 70e3
        vehicle[f"wheelset[{i}].longitudinal_position"] = place
        vehicle[f"wheelset[{i}].vertical_displacement"] = 0.0
    return FakeSlave("track", track), FakeSlave("vehicle", vehicle)


def filmed(frames=3, slow_motion=50.0, *, bogies=True, change=lambda track, vehicle, n: None):
    track, vehicle = pair(bogies=bogies)
    film = Film(slow_motion)
    film.begin(track, vehicle, wheelsets=4, step_size=STEP, steps=1000)
    for step in range((frames - 1) * film.every + 1):
        for i, place in enumerate(PLACES, 1):
            vehicle.values[f"wheelset[{i}].longitudinal_position"] = place + SPEED * STEP * step
        change(track.values, vehicle.values, step / film.every)
        film.observe(step * STEP)
    return film


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def test_frames_are_taken_at_whole_steps():
    film = filmed(slow_motion=60.0)
    assert film.every == 7  # 6.67
    assert film.slow_motion == pytest.approx(1.0 / (FRAME_RATE * 7 * STEP))
    assert film.times == pytest.approx(np.arange(3) * 7e-4)
    assert film.frames()["rail"].shape == (3, POINTS)
    assert film.scene.offsets == pytest.approx(OFFSETS)
    assert film.scene.window == pytest.approx(16 * 8 * 0.629)


def test_what_cannot_be_filmed_is_refused():
    track, vehicle = pair()
    with pytest.raises(ParameterError, match=r"slow-motion = 50\.0.*100001 frames, at most 5000"):
        Film(50.0).begin(track, vehicle, wheelsets=4, step_size=STEP, steps=800000)
    with pytest.raises(ParameterError, match=r"other\.fmu.*rail_profile.*take our track"):
        check_track({"window.start_position": 0}, "other.fmu")
    with pytest.raises(ParameterError, match=r"--animate.*omit --resume"):
        RunOptions(resume=True, out=Path("x.nc"), animate=Path("x.gif"))
    with pytest.raises(ParameterError, match=r"--slow-motion = 0\.0: must be greater than 0"):
        RunOptions(slow_motion=0.0)


def test_an_impact_between_two_frames_is_drawn_with_its_peak():
    """One step of 222 kN, three steps after a frame, and one without contact."""
    steps = {11 / 8: 222e3, 13 / 8: 0.0}  # 8 steps from frame to frame

    def strike(track, vehicle, n):
        for i in range(1, 5):
            track[f"wheelset[{i}].left.normal_force"] = 70e3
        track["wheelset[2].left.normal_force"] = steps.get(n, 70e3)

    film = filmed(4, change=strike)
    assert film.every == 8
    stage = Stage(film, 100.0)
    stage.show(1)
    assert max(stage._lines[1].get_ydata()) == 70.0
    stage.show(3)
    x, y = stage._lines[1].get_data()
    assert (np.diff(x) >= 0.0).all()
    assert (y.max(), y.min()) == (222.0, 0.0)
    assert x[y.argmax()] == pytest.approx(11 * SPEED * STEP)
    assert x[y.argmin()] == pytest.approx(13 * SPEED * STEP)
    assert x[-1] == pytest.approx(24 * SPEED * STEP)
    assert set(stage._lines[0].get_ydata()) == {70.0}
    low, high = stage._force.get_ylim()
    assert low < 0.0 < 222.0 < high


def test_largest_deflection_is_well_seen():
    """0.35 m for a millimetre: 200 is the largest of 1, 2, 5 times a power of ten."""
    assert default_exaggeration(filmed()) == 200.0
    flat = filmed(change=lambda track, vehicle, n: _flatten(track))
    assert default_exaggeration(flat) == 1.0


def _flatten(track):
    for name in track:
        if "profile.left" in name:
            track[name] = 0.0


def test_wheels_stand_on_the_rail():
    film = filmed()
    stage = Stage(film, 300.0)
    stage.show(1)
    rail = stage._rail.get_paths()[0].vertices
    for wheel, place in zip(stage._wheels, PLACES, strict=True):
        assert wheel.center[0] == pytest.approx(place)
        top = rail[np.abs(rail[:, 0] - place) < 0.05][:, 1].max()
        assert wheel.center[1] - RADIUS == pytest.approx(top, abs=0.01)
        assert top == pytest.approx(-0.3, abs=0.02)


def test_a_wheel_follows_its_displacement_and_turns():
    def lift(track, vehicle, n):
        vehicle["wheelset[1].vertical_displacement"] = -1e-3 * (n == 2)

    film = filmed(change=lift)
    stage = Stage(film, 100.0)
    stage.show(1)
    before = stage._wheels[0].center[1]
    stage.show(2)
    assert stage._wheels[0].center[1] - before == pytest.approx(0.1)
    assert stage._wheels[1].center[1] == pytest.approx(stage._wheels[2].center[1], abs=0.02)
    x, y = stage._spokes[1].get_data()
    way = 2 * SPEED * STEP * film.every
    # Clockwise, as it rolls to the right.
    assert np.arctan2(y[1] - y[0], x[1] - x[0]) == pytest.approx(-way / RADIUS)


def test_car_body_moves_and_pitches():
    def move(track, vehicle, n):
        vehicle["car_body.vertical_displacement"] = 1e-3 * n
        vehicle["bogie[1].pitch_angle"] = 1e-3 * n

    stage = Stage(filmed(change=move), 100.0)
    stage.show(0)
    car, bogie = (stage._bodies[name][0].get_xy().copy() for name in ("car", "bogie"))
    stage.show(1)
    assert (stage._bodies["car"][0].get_xy() - car)[:, 1] == pytest.approx(-0.1)
    turned = (stage._bodies["bogie"][0].get_xy() - bogie)[:4, 1]
    reach = 1.25 + 0.5 * RADIUS
    assert turned == pytest.approx(0.1 * reach * np.array([-1.0, 1.0, 1.0, -1.0]))


def test_fasteners_and_slabs_pass_below():
    film = filmed()
    stage = Stage(film, 100.0)
    stage.show(2)
    way = 2 * SPEED * STEP * film.every
    seats = np.array([segment[0][0] for segment in stage._fasteners.get_segments()])
    numbers = (seats + way) / 0.629 - 0.5
    assert numbers == pytest.approx(np.rint(numbers), abs=1e-9)
    assert seats.size == pytest.approx(30.0 / 0.629, abs=1.0)
    slabs = [path.vertices[:, 0] for path in stage._slabs.get_paths()]
    whole = [x for x in slabs if np.ptp(x) > 4.8]
    assert len(whole) >= 4
    for x in whole:
        middle = 0.5 * (x.min() + x.max()) + way
        assert middle / 5.032 - 0.5 == pytest.approx(round(middle / 5.032 - 0.5), abs=0.02)


def test_window_stays_on_the_line_until_it_slides():
    def slide(track, vehicle, n):
        track["window.start_position"] = -40.256 + 5.032 * (n == 2)

    stage = Stage(filmed(change=slide), 100.0)
    for number, start in ((0, -40.256), (1, -40.256), (2, -35.224)):
        stage.show(number)
        assert stage._window.get_x() == pytest.approx(start)
    assert stage._train.get_xdata() == pytest.approx(PLACES + 2 * SPEED * STEP * 8)
    assert "-35.2 m to 45.3 m" in stage._told.get_text()


def test_a_vehicle_without_bogies_is_its_wheels():
    stage = Stage(filmed(bogies=False), 100.0)
    stage.show(1)
    assert stage._bodies == {"bogie": [], "car": []}
    assert len(stage._wheels) == 4


def test_gif_has_all_frames(tmp_path):
    film = filmed(4)
    told = []

    class Reporter(Quiet):
        def progress(self, done, planned):
            told.append((done, planned))

    write_animation(film, tmp_path / "a.gif", Reporter(), exaggeration=100.0)
    with Image.open(tmp_path / "a.gif") as found:
        assert found.n_frames == 4
        assert found.size == (720, 360)
        first = np.array(found.convert("L"), dtype=float)
        found.seek(3)
        last = np.array(found.convert("L"), dtype=float)
    assert np.abs(first - last).max() > 50.0
    assert told[-1] == (4, 4)


def test_mp4_has_all_frames(tmp_path):
    try:
        program = ffmpeg()
    except ParameterError as error:
        pytest.skip(str(error))
    write_animation(filmed(5), tmp_path / "a.mp4", Quiet())
    told = subprocess.run(
        [program, "-i", tmp_path / "a.mp4", "-f", "null", "-"],
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    assert "h264" in told
    assert "1200x600" in told
    assert "yuv420p" in told
    assert "frame=    5" in told


def test_without_ffmpeg_the_remedy_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ParameterError, match=r"needs ffmpeg.*rail-cosim\[video\].*\.gif"):
        check_animation(tmp_path / "a.mp4")
    check_animation(tmp_path / "a.gif")


def test_other_places_are_refused(tmp_path):
    with pytest.raises(ParameterError, match=r"must end in \.mp4 or \.gif"):
        check_animation(tmp_path / "a.avi")
    (tmp_path / "file").touch()
    with pytest.raises(ResultsError, match="cannot be written"):
        check_animation(tmp_path / "file" / "a.gif")
    film = Film(50.0)
    film.begin(*pair(), wheelsets=4, step_size=STEP, steps=10)
    with pytest.raises(ResultsError, match="no frame to draw"):
        write_animation(film, tmp_path / "a.gif", Quiet())
