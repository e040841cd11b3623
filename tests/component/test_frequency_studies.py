"""``python -m slab_track.frequency`` and the studies that show it."""

import json

import numpy as np
import pytest
import rail_cosim.studies as studies
import xarray as xr
from rail_cosim.errors import ParameterError, RailCosimError, UnknownNameError
from rail_cosim.studies.track_frequency import setting_arguments
from rail_quantities import with_values
from slab_track import HD
from slab_track.frequency import (
    WHEELSET_ON_PRIMARY,
    Wheelset,
    coupled_modes,
    middle,
    p2_formula,
    receptance,
)
from slab_track.frequency.__main__ import main

SMALL = ("rail.mode_count=150", "slab.mode_count=20", "window.slab_count=7")
P = with_values(HD, {"rail.mode_count": 150, "slab.mode_count": 20, "window.slab_count": 7})


def settings(**more):
    values = dict(text.split("=") for text in SMALL) | more
    return {f"track.{name}" if "." in name else name: v for name, v in values.items()}


def study(name, folder, **more):
    result = studies.study(name, out=folder, quick=True, settings={**settings(), **more})
    data, picture = result.files
    assert picture.stat().st_size > 30_000
    with xr.open_dataset(data, engine="h5netcdf") as file:
        return result, file.load()


def value(data, name, **where):
    row = data.sel(**where)
    return complex(row[f"{name}_magnitude"] * np.exp(1j * row[f"{name}_phase"]))


def test_receptance_study_shows_what_the_package_computes(tmp_path):
    result, data = study("receptance", tmp_path)
    f = float(data["frequency"][40])
    for place, x in zip(("mid_bay", "fastener"), middle(P), strict=True):
        wanted = receptance(P, f, [x], [x, x + 2.5])
        at = {"place": place, "frequency": f}
        assert value(data, "same_rail", **at) == pytest.approx(wanted.same_rail[0, 0, 0])
        assert value(data, "other_rail", **at) == pytest.approx(wanted.other_rail[0, 0, 0])
        assert value(data, "next_wheel", **at) == pytest.approx(wanted.same_rail[0, 1, 0])
        assert value(data, "lateral", **at) == pytest.approx(wanted.lateral[0, 0, 0, 0, 0])
        assert value(data, "roll", **at) == pytest.approx(wanted.lateral[0, 0, 0, 1, 1])
    assert data.attrs["track.rail.mode_count"] == 150
    assert data["same_rail_magnitude"].attrs["units"] == "m/N"
    assert "1042.8 Hz in closed form" in result.conclusion


def test_receptance_of_rails_held_sideways(tmp_path):
    _, data = study("receptance", tmp_path, **{"track.rail.motion": "vertical"})
    assert not data["lateral_magnitude"].any()


def test_p2_study(tmp_path):
    result, data = study("p2", tmp_path, **{"vehicle.wheelset.mass": 1500})
    assert data.attrs["wheelset_mass"] == 1500.0
    row = data.sel(pad_stiffness=140e6)
    line = with_values(P, {"fastener.vertical_stiffness": 140e6})
    assert float(row["formula_frequency"]) == pytest.approx(p2_formula(line, 750.0).frequency)
    for name, wheelset, contact in (
        ("hertz", Wheelset(mass=1500.0), None),
        ("primary", WHEELSET_ON_PRIMARY.replace(mass=1500.0), None),
        ("rigid_contact", Wheelset(mass=1500.0), np.inf),
    ):
        for place, x in zip(("mid_bay", "fastener"), middle(P), strict=True):
            (mode,) = coupled_modes(line, wheelset, [x], contact_stiffness=contact)
            found = row.sel(place=place)
            assert float(found[f"{name}_frequency"]) == pytest.approx(mode.natural_frequency)
            assert float(found[f"{name}_damping_ratio"]) == pytest.approx(mode.damping_ratio)
    assert float(row["resonance_speed"].sel(place="mid_bay")) == pytest.approx(
        0.629 * float(row["primary_frequency"].sel(place="mid_bay"))
    )
    assert "140 MN/m: article 83.1 Hz" in result.conclusion


def test_fig10_study(tmp_path):
    _, data = study("fig10", tmp_path)
    assert list(data["pad_stiffness"]) == [40e6, 140e6]
    (mode,) = coupled_modes(P, WHEELSET_ON_PRIMARY, [middle(P).mid_bay])
    nominal = data.sel(pad_stiffness=40e6)
    assert float(nominal["natural_frequency"]) == pytest.approx(mode.natural_frequency)
    under = nominal.sel(rail_position=0.0, method="nearest")
    assert float(under["rail_magnitude"]) == pytest.approx(np.abs(mode.rail).max(), rel=1e-6)
    assert float(nominal["seat_magnitude"].max()) == pytest.approx(float(nominal["seat_amplitude"]))
    # Mirror-symmetric about the wheelset, which stands over the middle of a slab.
    slab = nominal["slab_magnitude"].to_numpy()
    assert slab == pytest.approx(slab[:, ::-1, ::-1], rel=1e-5, abs=1e-9)
    assert nominal["slab_position"].shape == (7, 41)


def test_fig10_with_a_chosen_stiffness(tmp_path):
    _, data = study("fig10", tmp_path, **{"track.fastener.vertical_stiffness": 60e6})
    assert list(data["pad_stiffness"]) == [60e6]


def test_bogie_mass_counts_for_two_wheelsets():
    assert setting_arguments(["vehicle.bogie.mass=3000"], wheelset=True) == [
        "--wheelset=frame_mass=1500.0"
    ]


@pytest.mark.parametrize(
    ("name", "changed", "kind", "match"),
    [
        ("receptance", {"track.rail.aria": 1}, RailCosimError, "did you mean rail.area"),
        ("p2", {"vehicle.wheelset.mass": -1}, RailCosimError, "wheelset.mass = -1.0.*greater"),
        ("p2", {"vehicle.wheelset.mass": "x"}, ParameterError, "vehicle.wheelset.mass.*number"),
        ("p2", {"vehicle.car_body.mass": 1}, UnknownNameError, "vehicle.wheelset.mass"),
        ("receptance", {"vehicle.wheelset.mass": 1}, UnknownNameError, "track.NAME"),
    ],
)
def test_refusals(tmp_path, name, changed, kind, match):
    with pytest.raises(kind, match=match) as caught:
        studies.study(name, out=tmp_path, quick=True, settings=changed)
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("rail.mode_count=many", "must be a number"),
        ("rail.residual_compliance=maybe", "must be true or false"),
        ("rail.mode_count", "there is no value"),
    ],
)
def test_command_refuses(tmp_path, capsys, text, match):
    assert main(["mode", "--track", text, "--out", str(tmp_path / "x.json")]) == 2
    assert match in capsys.readouterr().err


def test_command_writes_json_and_prints_figures(tmp_path, capsys):
    out = tmp_path / "mode.json"
    small = [word for text in SMALL for word in ("--track", text)]
    assert main(["mode", *small, "--track", "rail.residual_compliance=false", "--quick",
                 "--out", str(out)]) == 0  # fmt: skip
    data = json.loads(out.read_text())
    assert data["parameters"]["rail.residual_compliance"] is False
    assert len(data["columns"]["rail"]["real"]) == len(data["columns"]["rail_position"])
    assert f"damping_ratio = {data['about']['damping_ratio']:.6g}" in capsys.readouterr().out
