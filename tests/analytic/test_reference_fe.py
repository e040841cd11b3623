"""The finite-element reference against closed forms, other integration, and itself refined."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg
from reference_fe import (
    GRAVITY,
    ReferenceTrack,
    ReferenceVehicle,
    SingleWheel,
    band_limited_amplitude,
    build_line,
    receptance,
    simulate,
    static_deflection,
)
from reference_fe.beam import BeamSection, assemble_hinged
from reference_fe.line import static_compliance
from reference_fe.plate import half_slab, plate_matrices
from reference_fe.rolling_stock import rolling_stock
from scipy.integrate import solve_ivp

KMH = 1 / 3.6
HD = ReferenceTrack()
ZX = ReferenceTrack(
    fastener_spacing=0.63, fastener_count_per_slab=9, slab_length=5.6, slab_thickness=0.2
)
GOLDEN = Path(__file__).parents[1] / "golden" / "steady_state_amplitudes.json"


def full_matrix(diagonals: np.ndarray) -> np.ndarray:
    """Square matrix from diagonals by row."""
    size = diagonals.shape[1]
    inside = [slice(max(0, -d), size - max(0, d)) for d in range(-3, 4)]
    return sum(
        np.diag(row[part], d) for d, row, part in zip(range(-3, 4), diagonals, inside, strict=True)
    )


def hinged_frequencies(elements_per_bay: int, count: int) -> np.ndarray:
    """Lowest natural frequencies in Hz of the 65.416 m rail."""
    elements = 104 * elements_per_bay
    mass, stiffness = assemble_hinged(BeamSection.of(HD), 65.416 / elements, elements)
    free = np.setdiff1d(np.arange(mass.shape[1]), [0, mass.shape[1] - 2])
    inside = np.ix_(free, free)
    k, m = (scipy.sparse.csc_matrix(full_matrix(a)[inside]) for a in (stiffness, mass))
    square = scipy.sparse.linalg.eigsh(k, count, m, sigma=0.0, return_eigenvectors=False)
    return np.sqrt(np.sort(square)) / (2 * np.pi)


# --- elements


def timoshenko_frequency(mode: int) -> float:
    """First branch of the hinged Timoshenko rail of 65.416 m, in Hz."""
    section, wave = BeamSection.of(HD), mode * np.pi / 65.416
    bending, shear = section.bending_stiffness, section.shear_stiffness
    mass, inertia = section.mass_per_length, section.rotary_inertia
    # mass * inertia * w**4 - (...) * w**2 + bending * shear * wave**4 = 0
    square = np.roots(
        [
            mass * inertia,
            -(mass * (shear + bending * wave**2) + inertia * shear * wave**2),
            bending * shear * wave**4,
        ]
    )
    return float(np.sqrt(square.min()) / (2 * np.pi))


@pytest.mark.parametrize(
    ("mode", "frequency", "digits"), [(1, 0.1211, 5e-4), (10, 12.0743, 1e-5), (50, 283.68, 3e-5)]
)
def test_hinged_rail_has_the_frequencies_of_the_timoshenko_beam(mode, frequency, digits):
    assert timoshenko_frequency(mode) == pytest.approx(frequency, rel=digits)
    computed = hinged_frequencies(8, mode)[-1]
    assert computed == pytest.approx(frequency, rel=3e-4)
    assert computed == pytest.approx(timoshenko_frequency(mode), rel=2e-4)


def test_frequency_error_falls_with_the_square_of_the_element():
    exact = timoshenko_frequency(100)
    error = [hinged_frequencies(n, 100)[-1] / exact - 1 for n in (4, 8)]
    assert np.log2(error[0] / error[1]) == pytest.approx(2.0, abs=0.1)
    extrapolated = error[1] + (error[1] - error[0]) / 3
    assert abs(extrapolated) < 0.05 * error[1]


@pytest.mark.parametrize("place", [0.5, 1.0, 1.37, 2.93, 3.0])
def test_static_deflection_is_exact_under_a_load_anywhere_in_an_element(place):
    section, elements, length = BeamSection.of(HD), 5, 4.0
    _, stiffness = assemble_hinged(section, length / elements, elements)
    track = replace(HD, pad_stiffness=0.0)
    line = replace(
        build_line(track, 1, "symmetric"),
        rail_stiffness=stiffness,
        rail_mass=stiffness,
        track=replace(track, fastener_spacing=length / 5 * 2, rail_elements_per_bay=2),
    )
    load = line.load_vectors(np.array([place]))[: stiffness.shape[1], 0]
    local = line.local_compliances(np.array([place]))[0]
    deflection = load @ np.linalg.solve(full_matrix(stiffness), load) + local
    a, b = place, length - place
    bending = a**2 * b**2 / (3 * section.bending_stiffness * length)
    shear = a * b / (section.shear_stiffness * length)
    assert deflection == pytest.approx(bending + shear, rel=1e-10)


def test_rail_on_near_continuous_support_is_the_winkler_beam():
    dense = replace(
        HD, fastener_spacing=0.0629, pad_stiffness=4e6, slab_gap=0.01, slab_support_stiffness=1e12
    )
    middle = 14 * dense.pitch + 0.5 * dense.fastener_spacing
    at = np.array([middle])
    deflection = static_deflection(dense, at, np.array([69.21e3]), at, slab_count=28)
    assert deflection[0] == pytest.approx(0.7089e-3, rel=2e-4)


@pytest.mark.parametrize(
    ("ratio", "parameters"),
    [(1.0, (13.468, 19.596, 24.270)), (2.5, (21.454, 32.989, 59.629)), (0.4, (3.4326, 5.2782))],
)
def test_free_plate_has_the_frequency_parameters_of_converged_ritz_series(ratio, parameters):
    mass, stiffness = plate_matrices(
        np.linspace(-0.5, 0.5, 17),
        np.linspace(-0.5 / ratio, 0.5 / ratio, 17),
        rigidity=1.0,
        poisson_ratio=0.3,
        mass_per_area=1.0,
    )
    omega = np.sqrt(scipy.linalg.eigh(stiffness, mass, eigvals_only=True)[3 : 3 + len(parameters)])
    np.testing.assert_allclose(omega, parameters, rtol=1e-4)


@pytest.mark.parametrize(
    ("track", "frequencies"),
    [(HD, (25.52, 32.61, 70.59, 71.11)), (ZX, (23.57, 33.88, 65.22, 72.88))],
)
def test_free_slabs_of_both_lines(track, frequencies):
    halves = [half_slab(track, s).plate_frequency for s in ("symmetric", "antisymmetric")]
    found = np.sort(np.concatenate(halves)) / (2 * np.pi)
    assert found[2] < 0.01  # two rigid motions are symmetric, one antisymmetric
    np.testing.assert_allclose(found[3:7], frequencies, rtol=1e-3)
    assert np.count_nonzero(found[3:] < 450.0) == 21 or track is ZX


def test_seat_flexibility_of_the_slab_does_not_depend_on_the_modes_kept():
    few, many = (half_slab(replace(HD, slab_mode_count=n), "symmetric") for n in (8, 80))
    few, many = (s.seat_shape / s.stiffness @ s.seat_shape.T for s in (few, many))
    np.testing.assert_allclose(few, many, rtol=0, atol=1e-9 * many.max())


# --- statics and the frequency domain


def test_vehicle_at_rest_carries_its_weight_and_balances_an_offset_load():
    vehicle = ReferenceVehicle(load_offset=0.1)
    force = simulate(HD, vehicle, 300 * KMH, 0.01).wheel_force[0]
    assert force.shape == (4, 2)
    assert force.sum() == pytest.approx(vehicle.total_mass * GRAVITY, rel=1e-10)
    moment = (force[:, 1] - force[:, 0]).sum() * HD.rail_distance / 2
    assert moment == pytest.approx(vehicle.car_body_mass * GRAVITY * 0.1, rel=1e-9)


def test_vehicle_on_fixed_wheelsets_has_the_closed_form_frequencies():
    v = ReferenceVehicle()
    stock = rolling_stock(v, HD.rail_distance)
    sprung = np.flatnonzero(np.abs(stock.wheelset).sum(axis=0) == 0)
    inside = np.ix_(sprung, sprung)
    square = scipy.linalg.eigh(stock.stiffness[inside], stock.mass[inside], eigvals_only=True)
    primary, secondary = 8 * v.primary_stiffness, 4 * v.secondary_stiffness
    bogie_pitch = primary / 2 * v.half_wheelbase**2 / v.bogie_pitch_inertia
    expected = [bogie_pitch, bogie_pitch]
    # Car body and bogies in bounce, and in opposition (car body pitch about its middle).
    reach = v.half_bogie_distance**2
    for body in (v.car_body_mass, v.car_body_pitch_inertia / reach):
        matrix = [
            [secondary / body, -secondary / body],
            [-secondary / (2 * v.bogie_mass), (primary + secondary) / (2 * v.bogie_mass)],
        ]
        expected += list(np.linalg.eigvals(np.array(matrix)))
    np.testing.assert_allclose(square, np.sort(expected), rtol=1e-9)


def test_receptance_tends_to_the_static_compliance_and_is_reciprocal():
    line, places = build_line(HD, 24, "symmetric"), np.array([60.0, 61.3])
    _, compliance = static_compliance(line, places)
    low = receptance(HD, 60.0, np.array([1e-3]), response_positions=places, both_rails=True)
    np.testing.assert_allclose(low[0].real, compliance[0], rtol=1e-6)
    there = receptance(HD, 60.0, np.array([300.0]), response_positions=places[1:])
    back = receptance(HD, 61.3, np.array([300.0]), response_positions=places[:1])
    np.testing.assert_allclose(there, back, rtol=1e-8)


def test_midspan_receptance_peaks_at_the_pinned_pinned_frequency():
    frequencies = np.arange(1020.0, 1062.0, 2.0)
    midspan = 12 * HD.pitch + 4 * HD.fastener_spacing
    peak = np.abs(receptance(HD, midspan, frequencies, both_rails=True))[:, 0].argmax()
    assert frequencies[peak] == pytest.approx(1042.8, abs=4.0)


# --- time stepping


@pytest.mark.slow
def test_time_stepping_agrees_with_radau_on_the_same_semidiscrete_equations():
    track = replace(HD, rail_elements_per_bay=2, slab_mode_count=6)
    wheel, speed, margin = SingleWheel(), 300 * KMH, 2.5
    run = simulate(track, wheel, speed, 1.0, step=5e-6, margin=margin)
    line = build_line(track, 2, "symmetric")
    mass, damping, stiffness = (m.toarray() for m in line.matrices())
    inverse = np.linalg.inv(mass)
    n, start = len(mass), run.position[0, 0]

    def penetration(position: float, gap: float) -> float:
        local, root = line.locate(position)[2], max(gap, 0.0)
        for _ in range(30):  # root + local * (root / G)**1.5 = gap
            slope = 1 + 1.5 * local * np.sqrt(root) / wheel.hertz_constant**1.5
            root -= (root + local * (root / wheel.hertz_constant) ** 1.5 - gap) / slope
        return root

    def rate(time: float, y: np.ndarray) -> np.ndarray:
        u, v, z = y[:n], y[n : 2 * n], y[2 * n]
        load = line.load_vectors(np.array([start + speed * time]))[:, 0]
        force = (penetration(start + speed * time, z - load @ u) / wheel.hertz_constant) ** 1.5
        a = inverse @ (load * force - damping @ v - stiffness @ u)
        return np.concatenate([v, a, [y[-1], (wheel.static_load[0] - force) / wheel.mass]])

    response, _ = static_compliance(line, np.array([start]))
    y = np.concatenate([response[:, 0] * 69.21e3, np.zeros(n), [0.0, 0.0]])
    y[2 * n] = run.wheelset_displacement[0, 0]
    row = len(run.time) // 3
    end = run.time[row]
    exact = solve_ivp(rate, (0, end), y, "Radau", rtol=1e-6, atol=1e-9, first_step=1e-7)
    moved = run.wheelset_displacement[row, 0]
    assert abs(moved - y[2 * n]) > 1e-6
    assert moved - y[2 * n] == pytest.approx(exact.y[2 * n, -1] - y[2 * n], rel=1e-3)


def test_creeping_wheel_follows_the_static_deflection():
    run = simulate(HD, SingleWheel(), 2.0, 0.7, step=2e-4, margin=6.0)
    for row in np.linspace(200, len(run.time) - 1, 5).astype(int):
        at, force = run.position[row], run.wheel_force[row, :, 0]
        slabs = int(np.ceil((run.position[-1, 0] + 6.0) / HD.pitch))
        expected = static_deflection(HD, at, force, at, slab_count=slabs)
        assert run.rail_displacement[row, 0, 0] == pytest.approx(expected[0], rel=2e-3)


@pytest.mark.parametrize("vehicle", [SingleWheel(), ReferenceVehicle(load_offset=0.05)])
def test_energy_balance_of_a_run_closes_with_the_step(vehicle):
    def defect(step: float) -> float:
        run = simulate(
            HD, vehicle, 300 * KMH, 3.0, step=step, margin=6.0, spectral_radius=1.0,
            record_energy=True,
        )  # fmt: skip
        driven, lost = (
            np.trapezoid(p, dx=run.time[1]) for p in (run.driving_power, run.dissipated_power)
        )
        assert driven > 10.0
        return abs(run.final_energy - run.initial_energy - driven + lost) / driven

    coarse, fine = defect(1.25e-5), defect(3.125e-6)
    assert coarse < 3e-3
    assert fine < 0.5 * coarse


def test_both_sides_modelled_equal_one_side_under_equal_loads():
    one, both = (
        simulate(HD, ReferenceVehicle(), 300 * KMH, 4.0, step=1e-4, two_sided=flag)
        for flag in (False, True)
    )
    np.testing.assert_allclose(both.wheel_force[:, :, 0], one.wheel_force[:, :, 0], rtol=1e-8)
    np.testing.assert_allclose(both.wheel_force[:, :, 1], one.wheel_force[:, :, 0], rtol=1e-8)


def test_unequal_loads_mirror():
    runs = [
        simulate(HD, SingleWheel(static_load=load), 300 * KMH, 4.0, step=1e-4)
        for load in ((80e3, 50e3), (50e3, 80e3))
    ]
    left, right = (run.wheel_force[:, 0] for run in runs)
    assert np.abs(left[-1, 0] - left[-1, 1]) > 20e3
    np.testing.assert_allclose(left[:, ::-1], right, rtol=1e-8)


def test_quarter_car_filters_the_constant_load():
    stiff = SingleWheel(sprung_mass=6000.0, suspension_stiffness=2e6, suspension_damping=20e3)
    run = simulate(HD, stiff, 300 * KMH, 30.0, step=5e-5)
    plain = simulate(HD, SingleWheel(), 300 * KMH, 30.0, step=5e-5)
    assert run.wheel_force[0, 0, 0] == pytest.approx(69.21e3)
    change = run.amplitude(run.wheel_force) / plain.amplitude(plain.wheel_force) - 1
    assert 1e-3 < abs(change[0, 0]) < 0.1


def test_wheel_lifts_off_at_the_resonance_of_stiff_lightly_damped_pads():
    stiff = replace(HD, pad_stiffness=200e6, pad_damping=10e3)
    run = simulate(stiff, SingleWheel(), 180 * KMH, 20.0, step=5e-5)
    assert run.wheel_force.min() == 0.0
    assert run.wheel_force.max() > 120e3
    damped = simulate(replace(stiff, pad_damping=52e3), SingleWheel(), 180 * KMH, 20.0, step=5e-5)
    assert damped.wheel_force.min() > 0.25 * 69.21e3


# --- convergence


def amplitude(track: ReferenceTrack, speed_kmh: float = 300.0, **options: float) -> float:
    options = {"step": 5e-5, **options}
    run = simulate(track, SingleWheel(), speed_kmh * KMH, 27.0, **options)
    return float(run.amplitude(run.wheel_force)[0, 0])


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [40e6, pytest.param(200e6, marks=pytest.mark.slow)])
def test_amplitude_converges_with_the_rail_mesh(stiffness):
    track = replace(HD, pad_stiffness=stiffness)
    four, eight, sixteen = (amplitude(replace(track, rail_elements_per_bay=n)) for n in (4, 8, 16))
    assert abs(four - sixteen) < 5e-3 * sixteen
    assert abs(eight - sixteen) < 5e-4 * sixteen


@pytest.mark.slow
def test_amplitude_converges_with_the_step():
    rough, middle, fine = (amplitude(HD, step=h) for h in (1e-4, 5e-5, 2.5e-5))
    assert abs(middle - fine) < 5e-4 * fine
    assert abs(middle - fine) < 0.35 * abs(rough - fine)


@pytest.mark.slow
def test_amplitude_converges_with_the_slab_mesh_and_modes():
    track = replace(HD, pad_stiffness=200e6)
    base = amplitude(track)
    finer = replace(track, slab_elements_per_bay=4, slab_elements_across=10)
    assert amplitude(finer) == pytest.approx(base, rel=1e-3)
    assert amplitude(replace(track, slab_mode_count=30)) == pytest.approx(base, rel=1e-4)


@pytest.mark.slow
def test_line_ends_and_start_do_not_matter():
    base = amplitude(HD)
    assert amplitude(HD, margin=20.0) == pytest.approx(base, rel=1e-4)
    assert amplitude(HD, start_phase=0.2) == pytest.approx(base, rel=2e-4)
    assert amplitude(HD, spectral_radius=0.5) == pytest.approx(base, rel=5e-4)


def golden_cases() -> list[dict]:
    return json.loads(GOLDEN.read_text())["cases"]


def test_golden_table_is_converged_where_steady():
    cases = golden_cases()
    assert len(cases) == 45
    nominal = [c for c in cases if c["pad_damping"] == 52e3]
    assert all(c["steady"] and c["error_estimate"] < 3e-3 for c in nominal)
    assert sum(c["steady"] for c in cases) >= 40


def recompute(case: dict) -> np.ndarray:
    vehicle = {"single_wheel": SingleWheel(), "vehicle": ReferenceVehicle()}[case["vehicle"]]
    track = ReferenceTrack(
        pad_stiffness=case["pad_stiffness"],
        pad_damping=case["pad_damping"],
        rail_elements_per_bay=12,
    )
    speed = case["speed_kmh"] * KMH
    run = simulate(track, vehicle, speed, max(0.6 * speed, 30.0), step=5e-5)
    return run.amplitude(run.wheel_force)[:, 0]


def test_golden_value_of_the_nominal_line():
    case = next(c for c in golden_cases() if c["speed_kmh"] == 300.0)
    np.testing.assert_allclose(recompute(case), case["wheel_force_amplitude"], rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["single_wheel", "vehicle"])
def test_golden_table_of_nominal_damping(name):
    for case in golden_cases():
        if case["vehicle"] == name and case["pad_damping"] == 52e3:
            np.testing.assert_allclose(recompute(case), case["wheel_force_amplitude"], rtol=4e-3)


# --- the amplitude itself


def test_amplitude_keeps_the_band_and_drops_the_rest():
    time = np.arange(0.0, 1.0001, 1e-4)
    kept = 3.0 * np.cos(2 * np.pi * 40 * time) + 7.0
    dropped = 2.0 * np.sin(2 * np.pi * 800 * time)
    assert band_limited_amplitude(time, kept + dropped, 500.0, 0.1) == pytest.approx(3.0, rel=1e-9)
    assert band_limited_amplitude(time, kept + dropped, 1000.0, 0.1) > 4.5


def test_amplitude_of_a_period_that_is_no_multiple_of_the_step():
    time, period = np.arange(0.0, 0.5, 1e-4), 0.02 / 1.0037
    signal = np.cos(2 * np.pi * time / period)
    assert band_limited_amplitude(time, signal, 500.0, 2 * period) == pytest.approx(1.0, abs=2e-4)


def test_amplitude_refuses_a_window_longer_than_the_signal():
    with pytest.raises(ValueError, match="not longer than the signal"):
        band_limited_amplitude(np.arange(10.0), np.zeros(10), 0.1, 20.0)


def test_a_run_into_the_ends_is_refused():
    with pytest.raises(ValueError, match="at least one bay"):
        simulate(HD, SingleWheel(), 300 * KMH, 1.0, margin=0.1)


@pytest.mark.parametrize(
    ("change", "message"),
    [({"rail_elements_per_bay": 5}, "even number"), ({"slab_length": 6.0}, "fit its pitch")],
)
def test_impossible_tracks_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(HD, **change)
