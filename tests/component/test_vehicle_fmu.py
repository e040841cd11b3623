"""HighSpeedVehicle.fmu in a real host, beside the core it is made of."""

import textwrap
import zipfile
from functools import cache
from importlib.util import find_spec

import numpy as np
import pytest
from fmi_builds import folder, run_host
from rail_fmi.builder import build_fmu
from rail_quantities.terminals import CONTACT
from rail_vehicle import PAPER, ForceHistory, VehicleModel

PACKAGES = ("rail_quantities", "rail_fmi", "rail_vehicle")


@cache
def vehicle_fmu():
    return build_fmu(find_spec("vehicle_fmu").origin, PACKAGES, folder())


def run(code, *more):
    start = "import sys, math; from fmu_host import Host; F = sys.argv[1]\n"
    return run_host(start + textwrap.dedent(code), vehicle_fmu(), *more).splitlines()


def numbers(line):
    return np.array([float(word) for word in line.split()])


def test_named_vehicles_are_parameter_files():
    with zipfile.ZipFile(vehicle_fmu()) as fmu:
        for name in ("paper", "soft_primary", "manchester1"):
            text = fmu.read(f"resources/presets/{name}.ssv").decode()
            assert "primary_suspension.vertical_stiffness" in text
            assert '"speed"' not in text
        assert 'value="32000.0"' in fmu.read("resources/presets/manchester1.ssv").decode()


@pytest.mark.parametrize("settings", ["", "speed=40.0, car_body__mass=30000.0, gravity=9.7"])
def test_unconnected_vehicle_rolls_on_in_equilibrium(settings):
    lines = run(f"""
        host = Host(F).initialize({settings})
        print(host.get("static_wheel_load"), host.get("wheelset[2].contact.vertical_force"))
        first = host.get("wheelset[1].longitudinal_position"), host.get("speed_setpoint")
        assert host.step(100) is None
        print(*first, host.get("wheelset[1].longitudinal_position"))
        print(max(abs(host.get(f"wheelset[{{i}}].vertical_displacement")) for i in (1, 2, 3, 4)))
        print(host.get("car_body.longitudinal_velocity"), host.get("wheelset[4].pitch_rate"))
        host.close()
    """)
    load, vertical = numbers(lines[0])
    mass, gravity = (30000.0, 9.7) if settings else (44039.0, 9.81)
    assert load == pytest.approx((mass + 2 * 2439.0 + 4 * 1881.0) * gravity / 8.0)
    assert vertical == pytest.approx(-2.0 * load)
    start, setpoint, end = numbers(lines[1])
    speed = 40.0 if settings else 300.0 / 3.6
    assert start == 0.0
    assert setpoint == pytest.approx(speed)
    assert end == pytest.approx(speed * 0.1)
    assert numbers(lines[2]) == pytest.approx([0.0], abs=1e-15)
    assert numbers(lines[3]) == pytest.approx([speed, -speed / 0.46])


def force(step, name, wheelset):
    """Value that both the FMU and the core get: any smooth function will do."""
    if name == "vertical_force":
        return -2.0 * PAPER.static_wheel_load + 5e3 * np.sin(0.2 * step + wheelset)
    return 1e3 * np.cos(0.1 * step + wheelset + len(name))


def forces(step):
    return np.array([[force(step, name, i) for name, _, _ in CONTACT] for i in range(4)])


STEPS, SIZE = 30, 1e-3
WAYS = [("step_start", 1), ("step_start", 2), ("step_end", 1), ("step_end", 2)]


@cache
def steps_of_the_fmu():
    """Return the outputs after 30 steps, for each of the ways to read the forces."""
    rows = ";".join(" ".join(map(repr, forces(k).ravel().tolist())) for k in range(STEPS + 1))
    names = [f"wheelset[{i}].contact.{name}" for i in (1, 2, 3, 4) for name, _, _ in CONTACT]
    lines = run(
        f"""
        rows = [[float(word) for word in row.split()] for row in sys.argv[2].split(";")]
        names = {names}
        for time, order in {WAYS}:
            host = Host(F).initialize(
                coupling__input_time=time, coupling__force_order=order, **dict(zip(names, rows[0]))
            )
            for step in range({STEPS}):
                now = rows[step + (time == "step_end")]
                host.set(speed_setpoint=83.0, **dict(zip(names, now)))
                assert host.step(1, {SIZE}) is None
            print(*host.outputs())
            host.close()
        """,
        rows,
    )
    return dict(zip(WAYS, map(numbers, lines), strict=True))


@pytest.mark.parametrize("way", WAYS)
def test_fmu_makes_the_steps_of_the_core(way):
    input_time, order = way
    late = int(input_time == "step_end")
    model = VehicleModel(PAPER)
    state, history = model.initial_state(), ForceHistory.begin(forces(0))
    for step in range(STEPS):
        history = history.append(forces(step + late), SIZE if step or late else 0.0)
        curve = history.interpolate(order) if late else history.extrapolate(SIZE, order)
        state, outputs = model.step(state, curve.start, curve.end, SIZE, 83.0, curve.quadratic)
    assert np.abs(outputs.vector[1:5]).max() > 1e-5
    found = steps_of_the_fmu()[way][: outputs.vector.size]
    assert found == pytest.approx(outputs.vector, rel=1e-12, abs=1e-15)


def test_state_goes_to_another_process_and_back():
    save = run("""
        host = Host(F).initialize(speed=60.0, bogie__mass=2500.0)
        host.set(**{"wheelset[1].contact.lateral_force": 4000.0})
        host.step(7)
        state = host.fmu.getFMUState()
        data = host.fmu.serializeFMUState(state)
        host.step(9)
        print(data.hex()); print(repr(host.outputs()))
        host.fmu.setFMUState(state); host.time = 0.007; host.step(9)
        print(repr(host.outputs()))
        host.fmu.freeFMUState(state); host.close()
    """)
    assert save[1] == save[2]
    # A file, because the state is too long for a command line.
    place = folder() / "vehicle_state.hex"
    place.write_text(save[0])
    again = run(
        """
        host = Host(F).initialize(speed=20.0)
        data = bytes.fromhex(open(sys.argv[2]).read())
        state = host.fmu.deSerializeFMUstate(data)
        host.fmu.setFMUState(state); host.time = 0.007
        host.step(9)
        print(repr(host.outputs()))
        host.fmu.freeFMUState(state); host.close()
        """,
        place,
    )
    assert again[0] == save[1]


def test_set_speed_is_followed_and_unset_speed_is_not_taken_for_a_wish():
    lines = run("""
        host = Host(F).initialize(speed=50.0)
        host.set(speed_setpoint=float(host.vars["speed_setpoint"].start))
        host.step(10); print(host.get("car_body.longitudinal_velocity"))
        host.set(speed_setpoint=49.99); host.step(20)
        print(host.get("car_body.longitudinal_velocity"))
        host.set(speed_setpoint=50.0); host.step(20)
        print(host.get("car_body.longitudinal_velocity"))
        host.close()
    """)
    assert [float(line) for line in lines] == pytest.approx([50.0, 49.99, 50.0])


def test_heights_of_the_wheelsets_are_where_it_starts():
    lines = run("""
        heights = {f"wheelset[{i}].initial_vertical_displacement": 1e-5 * i for i in (1, 2, 3, 4)}
        host = Host(F).initialize(**heights)
        print(*(host.get(f"wheelset[{i}].vertical_displacement") for i in (1, 2, 3, 4)))
        host.close()
    """)
    assert numbers(lines[0]) == pytest.approx([1e-5, 2e-5, 3e-5, 4e-5])


def test_vehicle_starts_shifted_to_the_side():
    lines = run("""
        host = Host(F).initialize(initial_lateral_displacement=5e-3)
        print(*(host.get(f"wheelset[{i}].lateral_displacement") for i in (1, 2, 3, 4)))
        host.close()
    """)
    assert numbers(lines[0]).tolist() == [5e-3] * 4


def test_impossible_parameter_stops_the_run_with_its_name():
    lines = run("""
        for name, value in [
            ("wheelset__mass", -5.0),
            ("yaw_damper__blow_off_damping", 1e6),
            ("coupling__force_order", 3),
            ("coupling__input_time", "later"),
        ]:
            host = Host(F, name)
            assert host.refusal("initialize", **{name: value}) == 4
            print(" ".join(host.texts(4)[0].split()))
            host.close()
    """)
    expected = [
        ["wheelset.mass = -5.0", "0 kg"],
        ["yaw_damper.blow_off_damping", "300000"],
        ["coupling.force_order", "from 0 to 2"],
        ["coupling.input_time", "step_start, step_end"],
    ]
    for line, words in zip(lines, expected, strict=True):
        assert all(word in line for word in words)


def test_forces_beyond_all_bounds_stop_the_run_with_a_reason():
    lines = run("""
        host = Host(F).initialize()
        host.set(**{"wheelset[1].contact.lateral_force": 1e308})
        assert host.step(3, 1.0) == 4
        print(" ".join(host.texts(4)[0].split()))
        host.close()
    """)
    assert "no physical value" in lines[0]
    assert "Traceback" not in lines[0]
