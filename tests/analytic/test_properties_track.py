"""What holds for every track: equilibrium, passivity, mirror symmetry; random parameter sets.

Windows are short and modes few: these are properties of the model at any size.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_parameters import CONTACT, TRACK_RANGES, examples, mirrored, parameter_sets
from slab_track import TrackModel, TrackParameters
from slab_track.irregularity import IrregularityParameters
from slab_track.irregularity.parameters import CosineParameters, RailJointParameters
from slab_track.parameters import Rail, Slab, Window

STEP, SPEED = 1e-4, 70.0
SMALL = TrackParameters(
    rail=Rail(mode_count=60),
    slab=Slab(mode_count=12),
    window=Window(slab_count=5, method="moving_mass"),
    irregularity=IrregularityParameters(
        spectrum="german_low",
        start=-50.0,
        rail_joint=RailJointParameters(side="left", position=0.3),
        cosine=CosineParameters(side="right", direction="lateral", position=-0.1),
    ),
    wheelset_count=2,
)
SLIPPERY = SMALL.replace(contact=SMALL.contact.replace(friction_coefficient=0.0))
"""What rests by friction does so in many ways, in equilibrium in one."""

KEPT = ("wheelset_count", "contact.hertz_constant", "irregularity.start", "irregularity.seed")
FEW = tuple(name for name in CONTACT if name != "contact.friction_coefficient")


def tracks(defaults, *, contact):
    """Random sets; with ``contact`` wheel, rail and gauge vary too, a second for each set."""
    free = defaults is SLIPPERY
    keep = (*KEPT, "contact.friction_coefficient") if free else KEPT
    return parameter_sets(defaults, TRACK_RANGES, keep if contact else keep + FEW)


def counts(quick, slow):
    return pytest.mark.parametrize(
        ("count", "contact"), [(quick, False), pytest.param(slow, True, marks=pytest.mark.slow)]
    )


def standing(lateral=0.0, speed=0.0, radius=0.46):
    motion = np.zeros((2, 11))
    motion[:, 0], motion[:, 1] = (0.4, -1.9), lateral
    motion[:, 5], motion[:, 10] = speed, -speed / radius
    return motion


def begin(model, motion):
    """Equilibrium with the wheelsets at their static heights."""
    state = model.initial_state(motion)
    motion[:, 2] = state.static_heights
    return model.with_motion(state, motion)


@counts(10, 200)
def test_every_track_rests_under_its_wheelsets(count, contact):
    """Both on smooth rails and on irregular ones, wheelsets beside the middle."""

    @examples(count)
    @given(tracks(SLIPPERY, contact=contact), st.floats(-4e-3, 4e-3), st.booleans())
    def holds(p, lateral, smooth):
        if smooth:
            p = p.replace(irregularity=IrregularityParameters())
        model, motion = TrackModel(p), standing(lateral)
        state = begin(model, motion)
        load, first = p.static_wheel_load, model.outputs(state)
        np.testing.assert_allclose(first.contact[:, 2], -2.0 * load, rtol=1e-6)
        # Symmetric pairs (left + right)/sqrt(2): what all fasteners carry, but for the hinges.
        carried = np.sqrt(2.0) * state.fastener_force[0].sum()
        assert carried == pytest.approx(4.0 * load, rel=0.02)
        after = state
        for _ in range(10):
            after, out = model.step(after, motion, STEP)
        # A wheel's place between two rows of the step's tables: a nanometre, some newtons.
        np.testing.assert_allclose(out.contact[:, :3], first.contact[:, :3], atol=1e-3 * load)
        # The step's tables against exact statics: an offset of some 10 nm, which stays. Of the
        # larger deflection: beside a rail that carries all, the other one hardly moves.
        deflection = state.rail_deflection
        large = np.abs(deflection).max()
        np.testing.assert_allclose(after.rail_deflection, deflection, rtol=0, atol=1e-4 * large)

    holds()


@counts(10, 300)
def test_no_track_gives_more_than_it_got(count, contact):
    """From rest the work of any forces on the rail heads is stored or lost: never negative."""
    loose = SMALL.replace(interface="applied_force", static_wheel_load=0.0)

    @examples(count)
    @given(
        parameter_sets(loose, TRACK_RANGES, (*KEPT, *CONTACT, "static_wheel_load")),
        st.integers(0, 2**32 - 1),
    )
    def holds(p, seed):
        model, motion, rng = TrackModel(p), standing(), np.random.default_rng(seed)
        state, work, lowest, largest = model.initial_state(motion), 0.0, 0.0, 0.0
        rates, phases = rng.uniform(100.0, 4000.0, (2, 2, 3)), rng.uniform(0.0, 6.0, (2, 2, 3))
        size = np.array([1e4, 5e4, 1e3])
        before, force = np.zeros((2, 2, 3)), np.zeros((2, 2, 3))
        for n in range(1, 200):
            new = size * np.sin(rates * n * STEP + phases) * min(1.0, n / 20.0) * (n < 150)
            state, out = model.step(state, motion, STEP, applied_force=new)
            moved = np.stack([out.rail_lateral, out.rail_deflection, out.rail_roll], axis=2)
            work += float(np.sum(0.5 * (force + new) * (moved - before)))
            lowest, largest = min(lowest, work), max(largest, work)
            before, force = moved, new
        assert np.isfinite(state.vector[np.isfinite(model.initial_state(motion).vector)]).all()
        assert largest > 0.0
        assert lowest >= -1e-6 * largest

    holds()


@counts(8, 200)
def test_every_track_mirrors_its_mirror_image(count, contact):
    """Wheelsets that move sideways, roll and yaw over irregular rails, the left one jointed."""

    @examples(count)
    @given(
        tracks(SMALL, contact=contact),
        st.floats(-3e-3, 3e-3),
        st.floats(-2e-3, 2e-3),
        st.floats(-3e-3, 3e-3),
    )
    def holds(p, lateral, roll, yaw):
        found = []
        for parameters, side in ((p, 1.0), (mirrored(p), -1.0)):
            model = TrackModel(parameters)
            motion = standing(side * lateral, SPEED, parameters.contact.wheel_radius)
            motion[:, 3], motion[:, 4] = side * roll, side * yaw
            motion[:, 6], motion[:, 8], motion[:, 9] = side * 0.02, side * 0.01, side * 0.02
            state = begin(model, motion)
            rows = []
            for _ in range(12):
                motion = motion.copy()
                motion[:, :5] += STEP * motion[:, 5:10]
                state, out = model.step(state, motion, STEP)
                rows.append(out)
            found.append(rows)
        load = p.static_wheel_load
        for one, other in zip(*found, strict=True):
            image = other.contact * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
            np.testing.assert_allclose(image, one.contact, rtol=0, atol=1e-6 * load)
            np.testing.assert_allclose(
                other.normal_force[:, ::-1], one.normal_force, rtol=0, atol=1e-6 * load
            )
            np.testing.assert_allclose(
                -other.rail_lateral[:, ::-1], one.rail_lateral, rtol=0, atol=1e-12
            )
        assert np.isfinite(found[0][-1].wheel_outputs).all()

    holds()
