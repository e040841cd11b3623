"""Profiles from files: what is read, what is refused and what the message says."""

import numpy as np
import pytest
from rail_quantities import ParameterError
from slab_track import TrackParameters
from slab_track.assembly import assemble
from slab_track.contact import ContactParameters, build_tables, load_profile
from slab_track.contact.builtin_profiles import rail_60e1, wheel_s1002
from slab_track.parameters import Fastener, Rail, Slab


def write(path, y, z, header="# measured\n", separator=" "):
    rows = (f"{a:.6f}{separator}{b:.6f}" for a, b in zip(y, z, strict=True))
    path.write_text(header + "\n".join(rows) + "\n")
    return str(path)


def wheel_points(count=1200):
    y = np.linspace(-0.054, 0.059, count)
    return y, wheel_s1002().derivative(y)


def test_file_in_millimetres_gives_the_profile_back(tmp_path):
    y, z = wheel_points()
    profile = load_profile("wheel", write(tmp_path / "s1002.txt", 1e3 * y, 1e3 * z))
    inner = np.linspace(-0.05, 0.05, 700)
    assert profile.derivative(inner) == pytest.approx(wheel_s1002().derivative(inner), abs=6e-7)
    tread = np.linspace(-0.02, 0.02, 100)
    assert profile.derivative(tread, 1) == pytest.approx(
        wheel_s1002().derivative(tread, 1), abs=1e-4
    )
    assert profile.name == "s1002.txt"


@pytest.mark.parametrize("separator", ["\t", ";", ", "])
def test_metres_descending_order_and_separators(tmp_path, separator):
    y, z = wheel_points(300)
    header = "! by hand\n# unit: m\n"
    path = write(tmp_path / "w.csv", y[::-1], z[::-1] + 0.001, header, separator)
    profile = load_profile("wheel", path)
    # Heights count from the rolling circle, whatever the file's own zero was.
    assert float(profile.derivative(0.0)) == pytest.approx(0.0, abs=1e-9)
    assert float(profile.derivative(0.03)) == pytest.approx(
        float(wheel_s1002().derivative(0.03)), abs=2e-6
    )


def test_rail_counts_from_its_top(tmp_path):
    y = np.linspace(-0.0362, 0.0362, 900)
    path = write(tmp_path / "r.txt", 1e3 * y, 1e3 * rail_60e1().derivative(y) - 172.0)
    profile = load_profile("rail", path)
    assert float(profile.derivative(0.0)) == pytest.approx(0.0, abs=1e-8)
    assert float(profile.derivative(0.02)) == pytest.approx(
        float(rail_60e1().derivative(0.02)), abs=1e-6
    )


def test_smoothing_takes_noise_of_the_size_given(tmp_path):
    y = np.linspace(-0.05, 0.055, 2000)
    noise = np.random.default_rng(3).normal(0.0, 5e-6, y.size)
    path = write(tmp_path / "noisy.txt", 1e3 * y, 1e3 * (wheel_s1002().derivative(y) + noise))
    tread = np.linspace(-0.015, 0.02, 300)
    exact = wheel_s1002().derivative(tread, 1)
    rough = np.std(load_profile("wheel", path).derivative(tread, 1) - exact)
    smooth = np.std(load_profile("wheel", path, noise=5e-6).derivative(tread, 1) - exact)
    assert smooth < 0.1 * rough
    assert smooth < 5e-3


def test_outliers_that_no_spline_smooths_are_refused(tmp_path):
    y, z = wheel_points(60)
    z[40] = 1e24
    path = write(tmp_path / "spoilt.txt", 1e3 * y, 1e3 * z)
    with pytest.raises(ParameterError, match=r"contact\.profile_noise = 1e-05 m; remove outliers"):
        load_profile("wheel", path, noise=1e-5)


def test_contact_with_a_file_is_contact_with_the_profile(tmp_path):
    y, z = wheel_points(4000)
    path = write(tmp_path / "wheel.txt", 1e3 * y, 1e3 * z)
    by_name = build_tables(ContactParameters(rail_profile="60E1"))
    by_file = build_tables(ContactParameters(rail_profile="60E1", wheel_profile=path))
    # Heights of first touch of the tread, where the wheelset stays on it.
    inside = np.s_[0, 10:31, 100:420, 0]
    assert by_file.patch[inside] == pytest.approx(by_name.patch[inside], abs=1e-7)


def damaged(kind):
    y, z = wheel_points(300)
    if kind == "few":
        return y[::30], z[::30], ""
    if kind == "nan":
        return y, np.where(np.arange(y.size) == 40, np.nan, z), ""
    if kind == "back":
        return np.append(y, y[50]), np.append(z, z[50]), ""
    if kind == "unit":
        return 1e-3 * y, 1e-3 * z, ""
    if kind == "short":
        return y[y > -0.02], z[y > -0.02], ""
    if kind == "gap":
        keep = (y < 0.0) | (y > 0.01)
        return y[keep], z[keep], ""
    if kind == "sign":
        return y, -z, ""
    return y, z, "# unit: inch\n"


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("few", r"it has \d+ points; give at least 20"),
        ("nan", "not a finite number"),
        ("back", "turns back at .* mm; sort the points"),
        ("unit", "check the unit"),
        ("short", r"it must cover -45 to 30 mm"),
        ("gap", "there is no point between"),
        ("sign", "z counts down"),
        ("inch", "its unit is 'inch'; write '# unit: mm'"),
    ],
)
def test_refused_files_say_why(tmp_path, kind, message):
    y, z, header = damaged(kind)
    with pytest.raises(ParameterError, match=message) as refusal:
        load_profile("wheel", write(tmp_path / "bad.txt", 1e3 * y, 1e3 * z, header))
    assert refusal.value.name == "contact.wheel_profile"


def test_a_line_of_words_is_refused_with_its_number(tmp_path):
    path = tmp_path / "words.txt"
    path.write_text("1.0 2.0\nlateral height\n")
    with pytest.raises(ParameterError, match="line 2 is 'lateral height'"):
        load_profile("rail", str(path))


def test_decimal_commas_are_refused(tmp_path):
    path = tmp_path / "commas.txt"
    path.write_text("1,0 2,0\n")
    with pytest.raises(ParameterError, match="with decimal points"):
        load_profile("rail", str(path))


def test_unknown_name_lists_what_is_built_in():
    with pytest.raises(ParameterError, match=r"did you mean CHN60.*60E1, CHN60"):
        load_profile("rail", "CHN6O")


def test_shallow_rail_profile_is_refused_for_the_gauge(tmp_path):
    y = np.linspace(-0.0359, 0.0359, 900)
    path = write(tmp_path / "shallow.txt", 1.005 * 1e3 * y, 1e3 * rail_60e1().derivative(y))
    with pytest.raises(ParameterError, match="measure the gauge higher"):
        build_tables(ContactParameters(rail_profile=path), gauge_measurement_depth=0.016)


def test_parameters_are_checked():
    with pytest.raises(ParameterError, match=r"contact.friction_coefficient = 1.5"):
        ContactParameters(friction_coefficient=1.5)
    with pytest.raises(ParameterError, match=r"contact.fastsim_strips = 1"):
        ContactParameters(fastsim_strips=1)


def test_tables_are_kept_until_a_profile_s_file_changes(tmp_path):
    """Runs at many speeds in one process share them; a new measurement is read anew."""
    y = np.linspace(-0.0362, 0.0362, 900)
    heights = 1e3 * rail_60e1().derivative(y)
    path = write(tmp_path / "r.txt", 1e3 * y, heights)
    first = build_tables(ContactParameters(rail_profile=path))
    assert build_tables(ContactParameters(rail_profile=path)) is first
    assert build_tables(ContactParameters(rail_profile=path), cant=0.05) is not first
    assert build_tables(ContactParameters(rail_profile=path), cant=0.025) is first
    write(tmp_path / "r.txt", 1e3 * y, heights + 0.02 * y * 1e3)
    second = build_tables(ContactParameters(rail_profile=path))
    assert np.abs(second.patch - first.patch).max() > 1e-4


def test_the_linear_track_is_kept_for_equal_parameters():
    few = {"rail": Rail(mode_count=60), "slab": Slab(mode_count=6)}
    track = assemble(TrackParameters(**few))
    assert assemble(TrackParameters(**few)) is track
    other = assemble(TrackParameters(**few, fastener=Fastener(vertical_damping=10e3)))
    assert other is not track
