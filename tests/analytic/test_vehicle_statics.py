"""Static equilibrium and rigid motions of the vehicle against statics by hand."""

import numpy as np
import pytest
from rail_vehicle import MANCHESTER_1, PAPER, PRESETS, VehicleModel
from rail_vehicle.arrangement import make_bodies
from rail_vehicle.coordinates import FREE, WHEELSET_COORDINATES

WEIGHTLESS = PAPER.replace(gravity=0.0, speed=0.0)


def rigid_motions(parameters):
    """Return unit rigid motions of the whole vehicle about the origin, shape (6, 50)."""
    bodies = make_bodies(parameters)
    motions = np.zeros((6, 50))
    for index, body in enumerate((bodies.car_body, *bodies.bogies, *bodies.wheelsets)):
        for axis in range(3):
            unit = np.eye(3)[axis]
            motions[axis, 6 * index : 6 * index + 3] = unit
            motions[3 + axis, 6 * index : 6 * index + 3] = np.cross(unit, body.position)
            motions[3 + axis, 6 * index + 3 : 6 * index + 6] = unit
    motions[4, 42:] = 1.0
    return motions


def test_static_wheel_load_of_table_2():
    assert PAPER.static_wheel_load == pytest.approx(69.21e3, abs=5.0)


@pytest.mark.parametrize("name", PRESETS)
def test_static_forces_keep_the_vehicle_at_rest(name):
    model = VehicleModel(PRESETS[name])
    start = state = model.initial_state()
    forces = model.static_forces
    for _ in range(10_000):
        state, outputs = model.step(state, forces, forces, 1e-4)
    assert not state.vector[:90].any()
    assert state.speed == start.speed
    assert state.position - start.position == pytest.approx(start.speed * 1.0, rel=1e-9)
    assert outputs["axle_box[3].right.vertical_acceleration"] == 0.0


@pytest.mark.parametrize("parameters", [PAPER, MANCHESTER_1])
def test_contact_forces_of_equilibrium_carry_the_weight(parameters):
    model = VehicleModel(parameters)
    vertical = model.static_forces[:, 2]
    assert np.all(vertical < 0.0)
    assert vertical.sum() == pytest.approx(-parameters.total_mass * parameters.gravity)


def test_body_follows_wheelsets_raised_together():
    model = VehicleModel(PAPER)
    height = 3.0e-3
    coordinates = model.initial_state([height] * 4).coordinates
    assert coordinates[2:42:6] == pytest.approx(np.full(7, height), rel=1e-12)


def test_shift_to_the_side_is_rigid_and_keeps_the_vehicle_at_rest():
    """The whole vehicle moves, no suspension is strained: under static forces it stays there."""
    shift, height = 5.0e-3, 1.0e-4
    model = VehicleModel(PAPER.replace(initial_lateral_displacement=shift))
    expected = VehicleModel(PAPER).initial_state([height] * 4).coordinates
    expected[:42] += shift * rigid_motions(PAPER)[1, :42]
    assert model.initial_state([height] * 4).coordinates == pytest.approx(expected, abs=1e-15)
    state, forces = model.initial_state(), model.static_forces
    for _ in range(1000):
        state, outputs = model.step(state, forces, forces, 1e-3)
    assert outputs.motion[:, 1] == pytest.approx(np.full(4, shift), rel=1e-9)
    assert np.abs(state.rates[WHEELSET_COORDINATES[:, [1, 3, 5]]]).max() < 1e-10


def test_any_heights_of_the_wheelsets_leave_their_loads_nearly_equal():
    # Bogies pitch and the car body pitches freely on them, so four heights are no constraint.
    model = VehicleModel(PAPER)
    heights = np.array([1.0e-5, -2.0e-5, 3.0e-5, 1.5e-5])
    system = model.linear_system()
    coordinates = model.initial_state(heights).coordinates
    forces = system.stiffness @ coordinates
    assert coordinates[WHEELSET_COORDINATES[:, 2]] == pytest.approx(heights, rel=1e-12)
    assert np.abs(forces[WHEELSET_COORDINATES[:, 2]]).max() < 1.0  # N, of 138 kN
    others = np.setdiff1d(FREE, WHEELSET_COORDINATES[:, [1, 2, 3, 5]].ravel())
    assert np.abs(forces[others]).max() < 1e-9


def test_rigid_motion_strains_nothing_without_gravity():
    model = VehicleModel(WEIGHTLESS)
    system = model.linear_system()
    motions = rigid_motions(WEIGHTLESS).T
    scale = np.abs(system.stiffness) @ np.abs(motions)
    assert np.abs(system.stiffness @ motions).max() < 1e-12 * scale.max()
    assert np.abs(system.damping @ motions).max() < 1e-12 * np.abs(system.damping).max()
    assert np.abs(system.element_matrix.T @ motions).max() < 1e-13


def test_translation_and_yaw_strain_nothing_with_gravity():
    model = VehicleModel(PAPER)
    motions = rigid_motions(PAPER)[[0, 1, 2, 5]].T
    assert np.abs(model.linear_system().stiffness @ motions).max() < 1e-6


@pytest.mark.parametrize(("axis", "direction", "sign"), [(3, 1, -1.0), (4, 0, 1.0)])
@pytest.mark.parametrize("parameters", [PAPER, MANCHESTER_1])
def test_tilting_all_turns_the_suspension_forces_with_it(parameters, axis, direction, sign):
    """A vehicle tilted as a whole: every force of the suspensions tilts, nothing else changes.

    The forces on a body add up to its weight (on a wheelset, to the load on
    it), so the tilt turns the weight into a side force, and no moment.
    """
    system = VehicleModel(parameters).linear_system()
    found = -system.stiffness @ rigid_motions(parameters)[axis]
    g, car, bogie = parameters.gravity, parameters.car_body.mass, parameters.bogie.mass
    supported = [car * g, bogie * g, bogie * g] + [-(car + 2.0 * bogie) * g / 4.0] * 4
    expected = np.zeros(50)
    expected[direction:42:6] = -sign * np.array(supported)
    assert found == pytest.approx(expected, abs=1e-4)


def test_stiffness_is_symmetric_and_stable_on_held_wheelsets():
    stiffness = VehicleModel(PAPER).linear_system().stiffness
    assert np.abs(stiffness - stiffness.T).max() < 1e-6
    held = WHEELSET_COORDINATES[:, [0, 1, 2, 3, 5]].ravel()
    loose = np.setdiff1d(FREE, held)
    assert np.linalg.eigvalsh(stiffness[np.ix_(loose, loose)]).min() > 1e3


def test_sheared_springs_share_the_couple_of_their_load_between_both_seats():
    """Car body moved to the right: its weight stands half the way to the left of its centre."""
    stiffness = VehicleModel(PAPER).linear_system().stiffness
    weight = 44039.0 * 9.81
    lever = 1.71 - 0.76
    assert stiffness[3, 1] == pytest.approx(-0.5 * weight - 4.0 * 0.18e6 * lever, rel=1e-12)
    # Half of the load pushes on the leading bogie's frame, half the way to the right.
    above_frame = 0.76 - 0.50
    expected = -0.25 * weight - 2.0 * 0.18e6 * above_frame
    assert stiffness[9, 1] == pytest.approx(expected, rel=1e-12)


def solve_on_held_wheelsets(parameters, loads):
    """Displacements (50,) under loads (50,) with all wheelset coordinates held."""
    stiffness = VehicleModel(parameters).linear_system().stiffness
    loose = np.setdiff1d(FREE, WHEELSET_COORDINATES.ravel())
    displacement = np.zeros(50)
    displacement[loose] = np.linalg.solve(stiffness[np.ix_(loose, loose)], loads[loose])
    return displacement


def test_anti_roll_bar_shares_the_roll_moment_with_the_springs():
    parameters = WEIGHTLESS.replace(
        secondary_suspension=PAPER.secondary_suspension.replace(lateral_stiffness=1e-3)
    )
    primary, secondary = parameters.primary_suspension, parameters.secondary_suspension
    bar = parameters.anti_roll_bar.roll_stiffness
    moment = 1.0e4
    loads = np.zeros(50)
    loads[3] = moment
    found = solve_on_held_wheelsets(parameters, loads)
    upper = 2.0 * (bar + 2.0 * secondary.vertical_stiffness * secondary.half_span**2)
    lower = 2.0 * (4.0 * primary.vertical_stiffness * primary.half_span**2)
    assert found[9] == pytest.approx(moment / lower, rel=1e-6)
    assert found[3] == pytest.approx(moment / lower + moment / upper, rel=1e-6)


def test_vertical_stiffness_per_axle_box_is_the_parameter():
    loads = np.zeros(50)
    loads[[8, 14]] = 1.0e4
    found = solve_on_held_wheelsets(PAPER, loads)
    assert found[8] == pytest.approx(1.0e4 / (4.0 * 9.0e6), rel=1e-9)


def test_swing_arm_keeps_the_vertical_stiffness_and_turns_the_box():
    """With a stiff bush the frame's descent u turns the arm of length a by u/a."""
    arm = PAPER.primary_suspension.replace(guide_vertical_stiffness=13.7e6)
    parameters = PAPER.replace(primary_suspension=arm)
    loads = np.zeros(50)
    loads[[8, 14]] = 1.0e4
    descent = solve_on_held_wheelsets(parameters, loads)
    # Springs at +-b of the axle resist the turning: K_pz b^2 against K_gz a^2 in series.
    turning = 9.0e6 * 0.2**2
    bush = 13.7e6 * 0.48**2
    extra = turning * bush / (turning + bush) / 0.48**2
    assert descent[8] == pytest.approx(1.0e4 / (4.0 * (9.0e6 + extra)), rel=1e-9)
    pitch = descent[8] / 0.48 * bush / (turning + bush)
    assert descent[42:46] == pytest.approx([-pitch * s for s in (-1, -1, 1, 1)], rel=1e-9)


def test_lateral_offset_of_the_guide_gives_yaw_stiffness():
    """Held frame, one wheelset yawed: guide forces at the arms' ends by hand."""
    system = VehicleModel(WEIGHTLESS).linear_system()
    yaw = 1e-3
    moment = system.stiffness[WHEELSET_COORDINATES[0, 5]] @ (
        yaw * np.eye(50)[WHEELSET_COORDINATES[0, 5]]
    )
    expected = 2.0 * (13.7e6 * 1.0**2 + 5.5e6 * 0.48**2) * yaw
    assert moment == pytest.approx(expected, rel=1e-12)


def test_journal_carries_the_static_load_of_its_side():
    model = VehicleModel(PAPER)
    outputs = model.outputs(model.initial_state(), model.static_forces)
    sprung = (44039.0 + 2 * 2439.0) / 8.0
    assert outputs["axle_box[2].left.journal_force"] == pytest.approx((sprung + 84.0) * 9.81)
