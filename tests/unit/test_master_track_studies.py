"""Studies of convergence and of the three models of Table 1, on made-up runs."""

import numpy as np
import pytest
import xarray as xr
from rail_cosim.errors import RunError
from rail_cosim.studies import StudyOptions, convergence, run_study, table1
from rail_cosim.studies.article import BOX, FORCE
from rail_cosim.sweeps.quantities import evaluate

COUNTS = {"rail": (100, 256, 800), "slab": (24, 60, 240)}
PNG = b"\x89PNG"
BAY, PITCH, SPEED = 0.629, 5.032, 300 / 3.6


class Quietly:
    def stage(self, text):
        pass

    def progress(self, done, planned):
        pass

    def notice(self, text):
        pass


def made_points(specification, error):
    """Amplitudes of the finite elements times 1 + error(part, count, residual)."""
    values = {FORCE: [], BOX: []}
    for point in specification.all_points():
        case = next(
            c for c, (speed, pad) in convergence.CASES.items()
            if (speed, pad) == (point["speed"], point[convergence.STIFFNESS])
        )  # fmt: skip
        factor = 1.0
        for part, default in convergence.DEFAULTS.items():
            count = point[f"track.{part}.mode_count"]
            residual = point[f"track.{part}.residual_compliance"]
            if (count, residual) != (default, True):
                factor *= 1.0 + error(part, count, residual)
        for variable, quantity in ((FORCE, "force"), (BOX, "acceleration")):
            amplitude = np.array(convergence.FINITE_ELEMENTS[case][quantity]) * factor
            values[variable].append(np.repeat(amplitude[:, None], 2, axis=1))
    dims = ("point", "wheelset", "side")
    data = {f"{name}_half_range_500_hz": (dims, np.array(v)) for name, v in values.items()}
    count = len(values[FORCE])
    texts = np.full(count, "", dtype=object)
    return xr.Dataset({**data, "steady": ("point", np.ones(count)), "error": ("point", texts)})


@pytest.mark.parametrize(
    ("plain", "residual", "verdict"), [(0.3, 0.0, "pass"), (0.3, 0.02, "FAIL")]
)
def test_convergence_judges_the_default_counts_and_the_reference(
    plain, residual, verdict, monkeypatch, tmp_path
):
    seen = []

    def execute(specification, **options):
        seen.append(specification)
        return made_points(
            specification,
            lambda part, count, kept: (residual if kept else -plain) * (count / 100) ** -0.1,
        )

    monkeypatch.setattr(convergence, "execute_sweep", execute)
    monkeypatch.setattr(convergence, "COUNTS", COUNTS)
    result = run_study("convergence", StudyOptions(out=tmp_path), Quietly())
    assert result.conclusion.endswith(verdict)
    assert result.files[1].read_bytes().startswith(PNG)
    assert len(seen[0].points) == 2 * 2 * 2 * 3
    with xr.open_dataset(result.files[0], engine="h5netcdf") as data:
        at = data["rail_force_error"].sel(residual=0, rail_modes=100)
        # The reference is the finest with residual compliance, itself off by `residual`.
        finest = 1.0 + residual * 8**-0.1
        assert at.to_numpy() == pytest.approx(np.full(2, (1.0 - plain) / finest - 1.0))
        assert (data["rail_force_error"].sel(residual=1, rail_modes=800) == 0.0).all()
        away = data["rail_force_finite_elements"].to_numpy()
        assert away == pytest.approx(np.full(2, 1.0 / finest - 1.0), abs=1e-9)


def test_other_tracks_have_no_finite_elements_beside_them(monkeypatch, tmp_path):
    monkeypatch.setattr(
        convergence, "execute_sweep", lambda s, **o: made_points(s, lambda *of: 0.0)
    )
    options = StudyOptions(out=tmp_path, quick=True, settings=["track.rail.area=8e-3"])
    assert "finite elements" not in run_study("convergence", options, Quietly()).conclusion


def test_amplitudes_below_500_hz_leave_out_what_is_above():
    time = 1e-4 * np.arange(1001)
    low, high = np.cos(2 * np.pi * 130 * time), np.cos(2 * np.pi * 700 * time)
    run = xr.Dataset(
        {"force": (("time", "wheelset"), (9.0 + 2.0 * low + 5.0 * high)[:, None])},
        coords={"time": time},
        attrs={
            "steady": 1,
            "speed_km_h": 3.6,
            "track.fastener.spacing": 0.05,
            "track.fastener.count_per_slab": 2,
        },
    )
    found = evaluate(run, {"force": ["half_range_500_hz", "half_range"]})
    assert found["force_half_range_500_hz"].to_numpy() == pytest.approx([2.0], rel=1e-3)
    assert found["force_half_range"].to_numpy() > 6.0


def made_run(options, length, amplitude, cpu=1.0):
    way = 0.01 * np.arange(round(length / 0.01) + 1)
    force = (
        7e4
        + amplitude * np.sin(2 * np.pi * way / BAY)
        + 0.1 * amplitude * np.cos(2 * np.pi * way / PITCH)
    )
    if "track.window.method=moving_mass" in options.settings and length < 29:
        force[way > 17.5] += 100.0  # an end is felt
    modes = next(text for text in options.settings if "mode_count" in text).split("=")[1]
    slabs = next(text for text in options.settings if "slab_count" in text).split("=")[1]
    method = next(text for text in options.settings if "method" in text).split("=")[1]
    return xr.Dataset(
        {
            "normal_force": (
                ("time", "wheelset", "side"),
                np.broadcast_to(force[:, None, None], (len(way), 4, 2)),
            ),
            "distance": ("time", way),
        },
        coords={"time": way / SPEED},
        attrs={
            "macro_step": 0.01 / SPEED,
            "steps": len(way) - 1,
            "cpu_seconds": cpu * (len(way) - 1) / (PITCH / 0.01),
            "track.fastener.spacing": BAY,
            "track.fastener.count_per_slab": 8,
            "track.rail.mode_count": int(modes),
            "track.slab.mode_count": 60,
            "track.window.slab_count": int(slabs),
            "track.window.method": method,
        },
    )


def do_table1(monkeypatch, tmp_path, *, cyclic=1200.0, cost=1.0):
    def execute(options, reporter):
        method = next(text for text in options.settings if "method" in text).split("=")[1]
        short = "track.window.slab_count=13" in options.settings
        if method == "moving_mass" and short:
            raise RunError("a wheel comes near to the end", made_run(options, 22.0, 1200.0))
        amplitude = {"moving_irregularity": 0.5, "cyclic": cyclic}.get(method, 1200.0)
        return made_run(options, options.distance, amplitude, cost if method == "cyclic" else 1.0)

    monkeypatch.setattr(table1, "execute", execute)
    monkeypatch.setattr(table1, "_state_size", lambda options: 96000)
    result = run_study("table1", StudyOptions(out=tmp_path, quick=True), Quietly())
    assert result.files[1].read_bytes().startswith(PNG)
    with xr.open_dataset(result.files[0], engine="h5netcdf") as data:
        return result, data.load()


def test_table_1_finds_ratings_and_numbers(monkeypatch, tmp_path):
    result, data = do_table1(monkeypatch, tmp_path, cyclic=1150.0, cost=2.0)
    assert result.conclusion.startswith("9 of 9 ratings")
    mass = data.sel(model="moving_mass")
    assert (int(mass["ended"]), float(mass["way"])) == (1, pytest.approx(22.0))
    assert float(mass["felt_at"]) == pytest.approx(17.5, abs=0.02)
    assert float(mass["difference"]) == 0.0
    assert float(mass["whole_difference"]) == pytest.approx(100.0)
    ring = data.sel(model="cyclic")
    assert float(ring["sleeper_amplitude"]) == pytest.approx(1150.0, rel=1e-3)
    assert float(ring["slab_amplitude"]) == pytest.approx(115.0, rel=1e-3)
    assert float(ring["cpu_ratio"]) == pytest.approx(2.0)
    assert table1.ratings(data)["sleepers"]["cyclic"] == "partly"
    assert table1.ratings(data)["cost"]["cyclic"] == "no"
    degrees = data["degrees_of_freedom"]
    assert int(degrees.sel(model="sliding")) == 4 * 256 + 13 * 60
    assert int(degrees.sel(model="cyclic")) == 4 * 257 + 13 * 60
    assert int(degrees.sel(model="moving_mass_long")) > 4 * 256 + 13 * 60


def test_an_endless_model_that_ends_is_an_error(monkeypatch, tmp_path):
    def execute(options, reporter):
        raise RunError("a wheel comes near to the end", made_run(options, 22.0, 1200.0))

    monkeypatch.setattr(table1, "execute", execute)
    monkeypatch.setattr(table1, "_state_size", lambda options: 96000)
    with pytest.raises(RunError, match="near to the end"):
        run_study("table1", StudyOptions(out=tmp_path, quick=True), Quietly())


def test_the_long_window_holds_the_whole_way():
    settings = dict(text.split("=") for text in table1.model_settings("moving_mass_long", 100.0))
    slabs = int(settings["track.window.slab_count"])
    assert slabs * PITCH >= 100.0 + 20.3 + 15.0 + 3.0
    modes = int(settings["track.rail.mode_count"])
    assert modes / slabs == pytest.approx(256 / 13, abs=0.05)  # the same shortest wave
