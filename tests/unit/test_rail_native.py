"""Kernels as compiled entries, and what is refused."""

import numpy as np
import pytest
from rail_native import Core, NativeError
from rail_native.core import SWITCH
from rail_native.signature import ArrayKind, Group, parameters
from rail_vehicle import VehicleModel, VehicleParameters
from rail_vehicle.kernels import step
from slab_track.kernels.motion import extrapolate
from slab_track.kernels.transforms import make_transform, waves_to_samples


def test_signature_is_that_of_the_annotations():
    kinds = dict(parameters(waves_to_samples.plain))
    assert kinds["cosines"] is bool
    assert kinds["rows"] == ArrayKind("float64", 2)
    assert isinstance(kinds["transform"], Group)
    assert kinds["transform"].fields[0] == ("factors", ArrayKind("int64", 1))


@pytest.mark.parametrize(
    "rows", [np.zeros((4, 8), dtype=np.float32), np.zeros(8), np.zeros((8, 4)).T, [[0.0] * 8] * 4]
)
def test_an_array_that_is_not_the_right_one_is_refused(rows):
    with pytest.raises(TypeError, match="is not a contiguous array of"):
        waves_to_samples(make_transform(8, 4), False, rows)


def test_what_is_written_between_two_calls_of_a_bound_entry_is_seen():
    now, before, seen, out = np.zeros((1, 11)), np.zeros((1, 11)), np.ones(5), np.zeros((1, 11))
    call = extrapolate.bind(1.0, np.nan, now, before, seen, out)
    call()
    assert out[0, 0] == 0.0
    now[0, 5] = 83.0
    call()
    assert out[0, 0] == 83.0


def test_kernels_as_plain_python_give_what_the_library_gives(monkeypatch):
    model = VehicleModel(VehicleParameters())
    state, random = model.initial_state(), np.random.default_rng(3)
    forces = model.static_forces + 5e3 * random.normal(size=(4, 6))
    compiled, outputs = model.step(state, forces, forces, 1e-4)
    monkeypatch.setenv(SWITCH, "python")
    plain, same = VehicleModel(VehicleParameters()).step(state, forces, forces, 1e-4)
    np.testing.assert_allclose(plain.vector, compiled.vector, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(same.vector, outputs.vector, rtol=1e-9, atol=1e-9)


def test_a_library_of_other_sources_is_refused(monkeypatch):
    core = Core("rail_vehicle", modules=("kernels", "limits"))
    with pytest.raises(NativeError, match=r"compiled from other sources .* -m rail_native"):
        _ = core.library


def test_a_missing_library_is_told_with_the_remedy(monkeypatch, tmp_path):
    core = Core("rail_vehicle", modules=("kernels",))
    monkeypatch.setattr(Core, "folder", tmp_path)
    with pytest.raises(NativeError, match=r"no compiled core for this platform: .*Remedy"):
        _ = core.library


def test_an_entry_knows_its_plain_form():
    assert step.__name__ == "step"
    assert "communication step" in step.__doc__
