"""The compiled step against the equations in plain numpy, and these against energy and statics.

Random parameter sets, speeds and irregularities; the window shifts on the way, wheels lift off.
The kernels tabulate the rails' response over the distance, 256 points to a fastener bay: wheels
that stand at these points must agree to rounding, others as far as the interpolation goes.
"""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from random_parameters import CONTACT, TRACK_RANGES, examples, parameter_sets
from slab_track import TrackModel, TrackParameters
from slab_track.equations import TrackEquations
from slab_track.irregularity import IrregularityParameters
from slab_track.irregularity.parameters import RailJointParameters
from slab_track.kernel import PHASES
from slab_track.matrices import PHI, PSI, VERTICAL, Y, Z
from slab_track.parameters import Fastener, Rail, Slab, SlabSupport, Window

SMALL = TrackParameters(
    rail=Rail(mode_count=50),
    slab=Slab(mode_count=12),
    window=Window(slab_count=4, vehicle_offset=-0.5),
    irregularity=IrregularityParameters(
        spectrum="german_low",
        level_factor=0.3,
        cross_level_factor=0.1,
        start=-50.0,
        rail_joint=RailJointParameters(side="left", position=0.3),
    ),
    wheelset_count=2,
)
LEVEL = SMALL.replace(contact=SMALL.contact.replace(model="vertical"))
APPLIED = SMALL.replace(interface="applied_force", static_wheel_load=0.0)
KEPT = ("wheelset_count", "contact.hertz_constant", "irregularity.start")
SEEDS = st.integers(0, 2**32 - 1)


def drawn(count):
    """Return settings for so many examples: shrinking a failure takes too long here."""
    return settings(examples(count), phases=[Phase.generate])


def counts(quick, slow):
    return pytest.mark.parametrize("count", [quick, pytest.param(slow, marks=pytest.mark.slow)])


class Ride:
    """Wheelsets that come past the place of a window shift in the middle of some steps.

    ``points`` of the kernels' tables in a step, ``beside`` them in parts of their distance;
    ``fastest`` angular rate of the wheelsets' motion, rad/s.
    """

    def __init__(self, p, seed, points, beside=0.0, fastest=2000.0, steps=24):
        self.p, self.rng = p, np.random.default_rng(seed)
        self.step, self.steps = p.integration.maximum_step, steps
        grid = p.fastener.spacing / PHASES
        self.speed = points * grid / self.step
        shift_at = 0.5 * (p.window_length - p.slide_length) + p.window.vehicle_offset
        middle = round((shift_at - 0.5 * steps * points * grid) / grid) + beside
        half = round(0.6 / grid)
        self.x = grid * (middle + half * np.array([1.0, -1.0]))[: p.wheelset_count]
        self.rates = self.rng.uniform(50.0, fastest, (p.wheelset_count, 5))
        self.phases = self.rng.uniform(0.0, 6.0, self.rates.shape)

    def motion(self, n, size=(0.0, 0.0, 0.0, 0.0)):
        """Wheelsets (w, 11) at the end of step ``n``; ``size`` of what y, z, roll, yaw swing by."""
        time = n * self.step
        row = np.zeros((self.p.wheelset_count, 11))
        row[:, 0], row[:, 5] = self.x + self.speed * time, self.speed
        angle, begin = self.rates * time + self.phases, min(n / 4.0, 1.0) if n else 0.0
        slip = 2e-3 * begin * np.sin(angle[:, 0])
        row[:, 10] = -self.speed / self.p.contact.wheel_radius * (1.0 + slip)
        for i, half in enumerate(size, start=1):
            row[:, i] = begin * half * np.sin(angle[:, i])
            row[:, i + 5] = begin * half * self.rates[:, i] * np.cos(angle[:, i])
        return row


def pads_of(state):
    """Vertical fastener forces of a product's state, (P, 2)."""
    even, odd = np.sqrt(0.5) * state.fastener_force
    return np.stack([even - odd, even + odd], axis=1)


def waves_of(p, state):
    """Amplitudes of both rails' waves: vertical, its rotation, lateral, roll; each (3, 2, N)."""
    mass = 0.5 * p.window_length * p.rail.density
    aside, roll = np.sqrt(mass * p.rail.area), np.sqrt(mass * p.rail.polar_second_moment)
    tilt = np.sqrt(mass * p.rail.vertical_second_moment)
    fields = (Z, aside), (PSI, tilt), (Y, aside), (PHI, roll)
    return [state.rails[:, :, i] / of for i, of in fields]


def waves_of_product(model, state):
    """As :func:`waves_of`, of a product's state."""
    rail = model.linear.rail
    even, odd = state.symmetric.rail, state.antisymmetric.rail
    left_right = np.sqrt(0.5) * np.stack([even - odd, even + odd], axis=1)
    aside, sideways = model.lateral.bending.deflection, np.swapaxes(state.rails, 0, 1)
    return (
        np.sum(rail.deflection * left_right, axis=2),
        np.sum(rail.rotation * left_right, axis=2),
        np.sum(aside * sideways[:, :, :2], axis=2),
        model.lateral.torsion_amplitude * sideways[:, :, 2],
    )


def side_by_side(p, ride, size):
    """Yield states and outputs of the compiled step and of the equations, step by step."""
    model, equations = TrackModel(p), TrackEquations(p)
    motion = ride.motion(0, size)
    state, mine = model.initial_state(motion), equations.initial_state(motion)
    heights = state.static_heights
    assert mine.datum == pytest.approx(state.datum, rel=1e-9, abs=1e-12)
    for n in range(ride.steps):
        motion = ride.motion(n, size)
        motion[:, 2] += heights
        state, out = model.step(state, motion, ride.step)
        mine, found = equations.step(mine, motion, ride.step)
        yield state, out, mine, found
    assert mine.window_start == state.window_start
    assert state.slide_count == 1


@counts(5, 300)
def test_level_contact_agrees_to_rounding(count):
    lifted = []

    @drawn(count)
    @given(parameter_sets(LEVEL, TRACK_RANGES, (*KEPT, *CONTACT)), SEEDS, st.integers(1, 4))
    def holds(p, seed, points):
        ride = Ride(p, seed, points)
        for state, out, mine, found in side_by_side(p, ride, (0.0, 2e-4, 5e-5)):
            scale = 1e-10 * max(p.static_wheel_load, np.abs(out.normal_force).max())
            np.testing.assert_allclose(found.contact.on_wheelset, out.contact, rtol=0, atol=scale)
            np.testing.assert_allclose(found.contact.normal, out.normal_force, rtol=0, atol=scale)
            np.testing.assert_allclose(
                mine.pads[:, :, VERTICAL], pads_of(state), rtol=0, atol=scale
            )
            np.testing.assert_allclose(found.rail[..., 1], out.rail_deflection, rtol=0, atol=1e-13)
            lifted.append(np.any(out.normal_force == 0.0))

    holds()
    assert 0.02 < np.mean(lifted) < 0.98


@counts(2, 100)
def test_between_the_points_of_the_tables(count):
    @drawn(count)
    @given(parameter_sets(LEVEL, TRACK_RANGES, (*KEPT, *CONTACT)), SEEDS, st.floats(0.2, 4.0))
    def holds(p, seed, points):
        for _, out, _, found in side_by_side(p, Ride(p, seed, points, 0.5), (0.0, 5e-5, 2e-5)):
            scale = 1e-4 * max(p.static_wheel_load, np.abs(out.normal_force).max())
            np.testing.assert_allclose(found.contact.normal, out.normal_force, rtol=0, atol=scale)

    holds()


@counts(3, 100)
def test_the_linear_track_agrees_to_rounding(count):
    """Forces and moments on both rail heads, in all directions."""

    @drawn(count)
    @given(parameter_sets(APPLIED, TRACK_RANGES, (*KEPT, *CONTACT, "static_wheel_load")), SEEDS)
    def holds(p, seed):
        ride, model, equations = Ride(p, seed, 2), TrackModel(p), TrackEquations(p)
        motion = ride.motion(0)
        state, mine = model.initial_state(motion), equations.initial_state(motion)
        for n in range(ride.steps):
            motion = ride.motion(n)
            force = ride.rng.normal(size=(2, 2, 3)) * (1e4, 1e5, 1e3)
            state, out = model.step(state, motion, ride.step, applied_force=force)
            mine, found = equations.step(mine, motion, ride.step, applied_force=force)
            scale = 1e-10 * np.abs(force).max()
            np.testing.assert_allclose(
                mine.pads[:, :, VERTICAL], pads_of(state), rtol=0, atol=scale
            )
            np.testing.assert_allclose(found.rail[..., 1], out.rail_deflection, rtol=0, atol=1e-13)
        assert state.slide_count == 1
        for mine_, theirs in zip(waves_of(p, mine), waves_of_product(model, state), strict=True):
            scale = 1e-10 * np.abs(theirs).max(axis=(1, 2), keepdims=True)
            assert np.all(np.abs(mine_ - theirs) <= scale)
        for is_even, slabs in ((True, state.symmetric.slab), (False, state.antisymmetric.slab)):
            of = equations.track.plate.even == is_even
            scale = 1e-10 * np.abs(slabs).max(axis=(1, 2), keepdims=True)
            assert np.all(np.abs(mine.slabs[:, :, of] - slabs) <= scale)

    holds()


@pytest.mark.parametrize("at_end", [False, True])
def test_steps_of_unequal_size(at_end):
    """Of several internal steps each; rates of the roll are never given."""
    ride = Ride(LEVEL, 0, 1)
    model, equations, now = TrackModel(LEVEL), TrackEquations(LEVEL), 0
    state, mine = model.initial_state(ride.motion(0)), equations.initial_state(ride.motion(0))
    for count in (1, 2, 5, 1, 1, 6, 2, 4):
        motion = ride.motion(now + count * at_end, (0.0, 5e-5, 2e-5))
        motion[:, 2] += state.static_heights
        motion[:, 8] = 0.0
        state, out = model.step(state, motion, count * ride.step, at_end=at_end)
        mine, found = equations.step(mine, motion, count * ride.step, at_end=at_end)
        scale = 1e-10 * np.abs(out.normal_force).max()
        np.testing.assert_allclose(found.contact.normal, out.normal_force, rtol=0, atol=scale)
        now += count


TREAD, FLANGE, LIFTED = (
    (1e-3, 5e-5, 1e-4, 1e-3),
    (7.5e-3, 5e-5, 1e-4, 1e-3),
    (1e-3, 3e-4, 1e-4, 1e-3),
)


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 2, 3))])
@pytest.mark.parametrize("size", [TREAD, FLANGE, LIFTED], ids=["tread", "flange", "lifted"])
def test_profile_contact_agrees_within_the_solver_s_tolerance(size, seed):
    """In the bay where the kernels' tables of the lateral compliance are exact; 0.2 N a patch."""
    p = SMALL.replace(wheelset_count=1, window=Window(slab_count=4, method="moving_mass"))
    model, equations, ride = TrackModel(p), TrackEquations(p), Ride(p, seed, 4, fastest=150.0)
    bay = p.fastener.spacing
    ride.x = np.zeros(1)
    ride.x += model.initial_state(ride.motion(0)).window_start + 0.5 * p.window_length + 0.625 * bay
    y, loads = np.sign(0.5 - seed % 2) * (size[0] - 1e-3), []
    motion = ride.motion(0) + y * (np.arange(11) == 1)
    state, mine = model.initial_state(motion), equations.initial_state(motion)
    assert mine.datum == pytest.approx(state.datum, abs=1e-12)
    for n in range(ride.steps):
        motion = ride.motion(n, (1e-3, *size[1:])) + y * (np.arange(11) == 1)
        state, out = model.step(state, motion, ride.step)
        mine, found = equations.step(mine, motion, ride.step)
        np.testing.assert_allclose(found.contact.on_wheelset, out.contact, rtol=0, atol=1.5)
        np.testing.assert_allclose(found.contact.normal, out.normal_force, rtol=0, atol=1.5)
        creep = np.stack([out.longitudinal_creep_force, out.lateral_creep_force], axis=2)
        np.testing.assert_allclose(found.contact.creep, creep, rtol=0, atol=1.5)
        np.testing.assert_allclose(found.rail[..., 1], out.rail_deflection, rtol=0, atol=1e-9)
        np.testing.assert_allclose(found.rail[..., 2], out.rail_roll, rtol=0, atol=1e-7)
        loads.append(out.contact[0])
    place = (state.wheel_positions[0] - state.window_start) / bay
    assert 0.5 < place - 0.5 * p.fastener_count < 1.5
    lateral, vertical = np.abs(loads)[:, 1], np.abs(loads)[:, 2]
    assert lateral.max() > (1e4 if size is not FLANGE else 5e4)
    assert (vertical.min() == 0.0) == (size is LIFTED)


def test_profile_contact_past_a_window_shift():
    """Two wheelsets, whose lateral forces the kernels take to per cents only.

    They tabulate the rail's lateral compliance under a wheel in another bay, and neglect it between
    wheels within a step.
    """
    for _, out, _, found in side_by_side(SMALL, Ride(SMALL, 5, 4, fastest=150.0), TREAD):
        error = np.abs(found.contact.on_wheelset - out.contact) / SMALL.static_wheel_load
        assert np.all(error.max(axis=0) < [2e-3, 2e-2, 1e-3, 1e-2, 1e-3, 2e-2])


@pytest.mark.parametrize("p", [LEVEL, SMALL], ids=["vertical", "profiles"])
def test_the_equilibrium_rests(p):
    """It carries the load, and the step leaves it where it is."""
    p = p.replace(
        irregularity=IrregularityParameters(),
        contact=p.contact.replace(friction_coefficient=0.0),
    )
    equations, motion = TrackEquations(p), np.zeros((2, 11))
    motion[:, 0] = 0.3, -0.9
    start = state = equations.initial_state(motion)
    motion[:, 2] = state.static_heights
    assert state.pads[:, :, VERTICAL].sum() == pytest.approx(4.0 * p.static_wheel_load, rel=0.02)
    for _ in range(5):
        state, out = equations.step(state, motion, 1e-4)
        carried = -0.5 * out.contact.on_wheelset[:, 2]
        np.testing.assert_allclose(carried, p.static_wheel_load, rtol=1e-8)
        np.testing.assert_allclose(state.pads, start.pads, rtol=0, atol=1e-3)


def test_without_damping_energy_is_kept():
    """Of rails, slabs, fasteners and what the series leave out, after a push."""
    p = APPLIED.replace(
        fastener=Fastener(vertical_damping=0.0, lateral_damping=0.0),
        slab_support=SlabSupport(vertical_damping=0.0),
        window=Window(slab_count=4, method="moving_mass", end_damping=0.0),
    )
    equations, ride, energies = TrackEquations(p), Ride(p, 0, 0), []
    t, state, force = equations.track, equations.initial_state(ride.motion(0)), np.zeros((2, 2, 3))
    for n in range(100):
        force[:] = (1e4, 1e5, 1e3) * ride.rng.normal(size=(2, 2, 3)) * (n < 10)
        state, _ = equations.step(state, ride.motion(n), 1e-4, applied_force=force)
        q, v = (np.r_[state.rails[i].ravel(), state.slabs[i].ravel()] for i in (0, 1))
        pads = state.pads.ravel()
        energies.append(0.5 * (v @ v + q @ t.K @ q + pads**2 @ (1 / t.k_p) + pads @ t.R_pp @ pads))
    assert energies[9] > 1.0
    np.testing.assert_allclose(energies[10:], energies[10], rtol=1e-9)
