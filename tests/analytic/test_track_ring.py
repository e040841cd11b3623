"""The track closed to a ring: waves, statics, lateral motion, rotation, and against sliding."""

import numpy as np
import pytest
from pair import WholeVehicle, run_staggered
from rail_vehicle import VehicleModel, VehicleParameters
from slab_track import TrackModel, TrackParameters
from slab_track.contact import ContactParameters
from slab_track.equilibrium import rails_at_rest
from slab_track.kernel import kernel_table
from slab_track.kernels.distance import between, to_fasteners
from slab_track.parameters import Rail, Slab, Window
from slab_track.rail import vertical_modes
from slab_track.slide import slide_operator, slide_rail
from slab_track.waves import fastener_shapes, fold_table, waves

SLABS = Slab(mode_count=12)


def line(method, *, slabs=13, modes=240, **more):
    return TrackParameters(
        rail=Rail(mode_count=modes),
        slab=SLABS,
        window=Window(slab_count=slabs, method=method),
        **more,
    )


@pytest.mark.parametrize("ring", [False, True])
@pytest.mark.parametrize("count", [7, 12])
def test_waves_repeat_themselves_at_the_fasteners(count, ring):
    basis = fastener_shapes(count, ring=ring)
    gram = basis @ basis.T
    np.testing.assert_allclose(gram, np.diag(np.diag(gram)), atol=1e-10)
    assert np.diag(gram).min() > 0.4 * count
    along = waves(float(count), 6 * count, ring=ring)
    index, sign = fold_table(6 * count, count, ring=ring)
    here = along.shapes(np.arange(count) + 0.5)
    np.testing.assert_allclose(here, sign[:, None] * basis[index], atol=1e-9)


def test_kernel_of_a_ring_is_the_sum_over_its_waves():
    bays, length = 12, 7.5
    along = waves(length, 300, ring=True)
    weights = np.append(3.0, np.repeat(1.0 / np.arange(1, 151) ** 2, 2))
    table = kernel_table(weights, bays, ring=True)
    fasteners = (np.arange(bays) + 0.5) * length / bays
    for x in (0.05, 3.21, 7.45):
        found = np.empty(bays)
        to_fasteners(table, x / length * bays, found)
        exact = along.shapes(fasteners).T @ (weights[:, None] * along.shapes(np.array([x])))
        np.testing.assert_allclose(found, exact[:, 0], atol=1e-5)
        pair = along.shapes(np.array([x, 6.9]))
        one = between(table, x / length * bays, 6.9 / length * bays, True)
        assert one == pytest.approx(pair[:, 0] @ (weights * pair[:, 1]), abs=1e-5)


def test_rotation_is_exact_for_deflection_and_rotation():
    """Any field at all, not only compact ones: f(x + L) everywhere, twice over the joint."""
    p = line("cyclic", slabs=4, modes=40)
    rail = vertical_modes(p.rail, p.window_length, ring=True)
    q = np.random.default_rng(1).normal(size=(2, rail.wave_number.size))
    operator = slide_operator(
        rail, length=p.window_length, shift=p.pitch, sample_count=0, solver="least_squares"
    )
    moved = slide_rail(rail, operator, q)
    x = np.linspace(0.0, p.window_length, 57)

    def fields(q, x):
        z, psi = np.sum(rail.deflection * q, axis=0), np.sum(rail.rotation * q, axis=0)
        return np.stack([z @ rail.waves.shapes(x), psi @ rail.waves.rotation_shapes(x)])

    scale = np.max(np.abs(fields(q, x)), axis=1, keepdims=True)
    np.testing.assert_allclose(fields(moved, x) / scale, fields(q, x + p.pitch) / scale, atol=1e-11)


def test_equilibrium_of_a_ring_is_that_of_a_hinged_window():
    """Far from its ends the hinged window does not know of them; the ring has none."""
    places = np.array([31.3, 33.8])
    force = np.array([[[2e4, 6e4, 1e3], [-1e4, 8e4, 2e3]], [[5e3, 7e4, -1e3], [1e4, 6.5e4, 5e2]]])
    found = []
    for method in ("sliding", "cyclic"):
        model = TrackModel(line(method, wheelset_count=2))
        found.append(rails_at_rest(model.linear, model.lateral, places, force))
    scale = np.max(np.abs(found[0].motion), axis=(0, 1)) + 1e-30
    assert np.max(np.abs(found[1].motion - found[0].motion) / scale) < 5e-4
    for i in (0, 1):
        a, b = found[0].vertical[i], found[1].vertical[i]
        assert np.max(np.abs(a.fastener - b.fastener)) < 2e-4 * np.max(np.abs(a.fastener))
    # All of the load is carried, exactly.
    total = np.sqrt(0.5) * np.sum(force[:, :, 1])
    assert np.sum(found[1].vertical[0].fastener) == pytest.approx(total, rel=1e-12)


def test_a_resting_ring_stays_at_rest_under_forces_in_all_directions():
    load = np.array([[[2e4, 7e4, -2e3], [1e4, 6e4, 1e3]]])
    p = line("cyclic", slabs=8, modes=160, wheelset_count=1, interface="applied_force")
    model = TrackModel(p)
    row = np.zeros((1, 11))
    row[0, 0] = 0.13
    state = model.initial_state(row)
    axis = model.stepper.on_axis(load)
    rest = rails_at_rest(model.linear, model.lateral, row[:, 0] - state.window_start, axis)
    state = state.replace(
        symmetric=model._field(0, rest.vertical[0]), antisymmetric=model._field(1, rest.vertical[1])
    )
    state.rails[:, 0] = rest.lateral
    for _ in range(100):
        state, out = model.step(state, row, 1e-4, applied_force=load)
    np.testing.assert_allclose(out.rail_deflection, rest.motion[:, :, 1], rtol=1e-6)
    np.testing.assert_allclose(out.rail_roll, rest.motion[:, :, 2], rtol=1e-5)


def forces(method, distance, *, model="vertical"):
    """Run the whole vehicle at 300 km/h."""
    speed = 300 / 3.6
    track = TrackModel(line(method, modes=256, contact=ContactParameters(model=model)))
    vehicle = WholeVehicle(VehicleModel(VehicleParameters(speed=speed)))
    return run_staggered(track, vehicle, distance=distance, speed=speed, step=1e-4)


@pytest.mark.parametrize("model", ["vertical", "profiles"])
def test_ring_and_sliding_window_give_the_same_forces(model):
    """Two windows with nothing in common but the track: hinged and cut, or closed."""
    ring, slide = forces("cyclic", 15.0, model=model), forces("sliding", 15.0, model=model)
    assert ring.slide_count[-1] == slide.slide_count[-1] >= 2
    assert np.max(np.abs(ring.normal_force - slide.normal_force)) < 5.0  # N of 69 kN
