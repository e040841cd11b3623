"""The slave in a real host: instances, errors, states, several FMUs in a process."""

import shutil
import subprocess
import sys
import textwrap

import pytest
from fmi_builds import (
    PACKAGES,
    SECOND_ENTRY,
    SUPPORT,
    doubler_fmu,
    mass_spring_fmu,
    run_host,
    run_process,
)
from rail_fmi.builder import build_fmu

START = "import sys, gc, math, struct; from fmu_host import Host; F = sys.argv[1]\n"


def run(code: str, *more: object, **keywords: object) -> list[str]:
    code = START + textwrap.dedent(code)
    return run_host(code, mass_spring_fmu(), *more, **keywords).splitlines()


def test_three_instances_run_and_load_again():
    lines = run("""
        for _ in range(2):
            hosts = [Host(F, f"i{i}").initialize(force=100.0 * i, mass=50.0) for i in range(3)]
            for _ in range(20):
                assert all(host.step() is None for host in hosts)
            print(*[host.get("position") for host in hosts], hosts[1].get("omega"))
            print(hosts[2].get("steps"), hosts[2].get("moving"), hosts[2].get("say")[-4:])
            for host in hosts:
                host.close()
        assert Host.__module__ == "fmu_host" and not [p for p in sys.path if "resources" in p]
        import mass_spring; print("mass_spring-" in mass_spring.__file__)
    """)
    assert lines[0] == lines[2] == f"0.0 0.01 0.02 {(1e4 / 50) ** 0.5}"
    assert lines[1].encode("utf-8", "surrogateescape").startswith(b"20 ")
    assert lines[4] == "True"  # imported from the cache, not from the extracted FMU


def test_many_instantiations_with_collected_garbage():
    """At each one, pythonfmu gives back one reference too many; see ``bundle.prepare``."""
    run("""
        for _ in range(30):
            host = Host(F).initialize(); gc.collect()
            assert host.step() is None
            host.close(); gc.collect()
    """)


def test_instance_freed_at_once():
    """Its message from the constructor must not meet a logger that is gone."""
    run("Host(F).fmu.freeInstance()", MALLOC_PERTURB_="165")
    run("""
        host = Host(F).initialize()
        assert host.texts(0)[0] == "declared 100 %", host.log; host.close()
    """)


@pytest.mark.skipif(
    not sys.platform.startswith("linux") or shutil.which("cc") is None,
    reason="needs Linux and a C compiler",
)
def test_library_is_unloaded_without_a_double_free(tmp_path):
    watch = tmp_path / "watch_delete.so"
    source = SUPPORT / "watch_delete.c"
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", watch, source], check=True)
    run(
        "for _ in range(3):\n    host = Host(F).initialize(); host.step(); host.close()",
        LD_PRELOAD=str(watch),
    )


FAULTY = {
    "mass=-1.0": "mass = -1.0: must be from 0 to 1e+06 kg",
    "mass=0.0": "mass = 0.0: must be greater than 0",
    "mass=2000.0, spring__law='cubic'": "too heavy for the cubic law; 5 % less",
    "spring__law='quartic'": "spring.law = 'quartic': must be one of linear, cubic",
    "substeps=0": "substeps = 0: must be from 1 to 1000",
    "error='initialize'": "RuntimeError: cannot set up, 100 % sure %s %n",
    "force=math.nan": "values must be finite: force = nan",
    "position=1.0": "position is calculated by the model and cannot be set",
}


def test_faulty_set_up_is_refused_with_its_reason():
    run(f"""
        for values, message in {FAULTY!r}.items():
            host = Host(F, values)
            assert host.refusal("initialize", **eval(f"dict({{values}})")) == 4
            (text,) = host.texts(4)
            assert message in text and message in host.get("status.message"), (values, text)
            assert host.step() == 4 == host.step()
            assert math.isnan(host.get("position")) and not math.isnan(host.get("mass"))
            host.fmu.reset()
            assert host.initialize().step() is None and host.get("status.message") == ""
            host.close()
    """)


def test_refused_instances_are_given_back():
    """At an exception pythonfmu gives its references back twice; see ``GuardedSlave``."""
    run(
        """
        for i in range(10):
            host = Host(F, f"i{i}", logging=i % 2)
            host.refusal("initialize", mass=-1.0); gc.collect()
            host.fmu.reset(); host.initialize(); host.set(error="step")
            assert host.step() == 4 == host.step(); gc.collect(); host.close()
        gc.collect()
        assert not [o for o in gc.get_objects() if type(o).__name__ == "MassSpring"]
        """,
        PYTHONMALLOC="debug",
        MALLOC_PERTURB_="165",
    )


def test_reason_is_on_stderr_unless_logging_is_on():
    done = run_process(
        """
        import sys; from fmu_host import Host
        for i, logging in enumerate((False, True, False, True, True)):
            host = Host(sys.argv[1], f"i{i}", logging=logging)
            if i in (2, 3): host.fmu.setDebugLogging(not logging, [])
            if i == 4: host.fmu.setDebugLogging(True, ["logStatusError"])  # not pythonfmu's own
            assert host.refusal("initialize", mass=-1.0 - i) == 4
            print(len(host.texts(4)))
            host.close()
        """,
        mass_spring_fmu(),
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["0", "1", "1", "0", "0"]
    told = [f"MassSpring (i{i}): mass = {-1.0 - i}: must be from 0 to 1e+06 kg" for i in (0, 3, 4)]
    lines = done.stderr.splitlines()
    assert len(lines) == 3, done.stderr
    assert all(map(str.startswith, lines, told)), done.stderr


def test_corrected_set_up_runs():
    lines = run("""
        host = Host(F); host.fmu.setupExperiment(); host.fmu.enterInitializationMode()
        host.set(mass=-1.0); host.get("position"); print(len(host.texts()))
        host.set(mass=1.0); host.fmu.exitInitializationMode()
        print(host.step(), repr(host.get("status.message")), host.get("omega")); host.close()
    """)
    assert lines == ["1", "None '' 100.0"]


ON_DEMAND = {
    "step": "the wheel left the window;\nmove it 10 % back",
    "bug": "ZeroDivisionError: %s%n 50 %\nTraceback",
    "exit": "SystemExit: enough",
    "nan": "values must be finite: position = nan, velocity = nan",
}


def test_error_in_a_step_ends_the_run():
    run(f"""
        for error, message in {ON_DEMAND!r}.items():
            host = Host(F, error).initialize(); assert host.step(3) is None
            host.set(error=error); assert host.step() == 4, error
            (text,) = host.texts(4)
            assert message in text, text
            assert message.partition("\\nTrace")[0] in host.get("status.message")
            assert math.isnan(host.get("position")) and host.step() == 4
            assert math.isnan(struct.unpack("<d", bytes.fromhex(host.get("outputs.packed"))[:8])[0])
            host.close()
    """)


def test_any_text_can_be_logged():
    run("""
        host = Host(F).initialize(error="talk"); assert host.step() is None
        assert host.texts(1)[0].startswith("100 %\\n%s %n \\\\udcff\\\\0long"), host.texts(1)
        assert "started at 100 %" in host.texts(0); host.close()
    """)


def test_misuse_of_the_interface_is_an_error_not_a_crash():
    run("""
        import ctypes
        host = Host(F).initialize()
        assert host.refusal("setReal", [99], [1.0]) == 4 == host.refusal("getReal", [99])
        assert "value reference 99 does not exist: there are 8" in host.texts(4)[0]
        assert host.step() == 4; host.close()
        host = Host(F, "late").initialize(); assert host.refusal("set", mass=2.0) == 4
        assert "mass is a fixed parameter" in host.texts(4)[0]; host.close()
        host = Host(F, "output").initialize(); assert host.refusal("set", position=2.0) == 4
        assert "position is calculated by the model" in host.texts(4)[0]; host.close()
        host = Host(F, "early")
        assert host.step() == 4 and "initialise first" in host.texts(4)[0]; host.close()
        host = Host(F, "latin")
        text, reference = (ctypes.c_char_p * 1)(b"M\\xfcller"), (ctypes.c_uint * 1)(0)
        assert host.refusal("fmi2SetString", host.fmu.component, reference, 1, text) == 4
        assert "is not UTF-8" in host.texts(4)[0]; host.close()
    """)


def test_step_from_another_time_is_refused():
    run("""
        for wrong in (1.1e-3, 0.0, 1.0, -1e-3, math.nan):
            host = Host(F, str(wrong)).initialize(); assert host.step() is None
            host.time = wrong; assert host.step() == 4
            assert f"from t = {wrong!r} s was asked for, but" in host.texts(4)[0]
            assert "the FMU is at t = 0.001 s" in host.texts(4)[0]; host.close()
        host = Host(F, "rounding").initialize()
        for i in range(1000):
            host.time = 1e-3 * i * (1 + 1e-15); assert host.step() is None
        host.time -= 5e-7; assert host.step() is None; host.close()
    """)


def test_input_that_is_not_finite_is_named():
    run("""
        host = Host(F).initialize(); host.set(force=math.inf); host.set(force=1.0)
        assert host.step() is None
        host.set(force=math.nan); assert host.step() == 4
        assert "values must be finite: force = nan" in host.texts(4)[0]; host.close()
    """)


def test_input_that_is_not_finite_is_named_after_it_came_with_a_state():
    run("""
        host = Host(F).initialize(); host.step(3)
        host.set(force=math.nan); state = host.fmu.getFMUstate()
        host.set(force=1.0); assert host.step() is None
        host.fmu.setFMUstate(state); host.time = 0.003; assert host.step() == 4
        assert "values must be finite: force = nan" in host.texts(4)[0]
        host.fmu.freeFMUstate(state); host.close()
    """)


def test_packed_outputs_are_the_single_ones():
    """In the order of the description: reals, then integers; alone or among other texts."""
    run("""
        host = Host(F).initialize(force=3.0, spring__law="cubic"); host.step(17)
        outputs = [v for v in host.about.modelVariables if v.causality == "output"]
        names = [v.name for kind in ("Real", "Integer") for v in outputs if v.type == kind]
        wanted = struct.pack(f"<{len(names)}d", *[host.get(name) for name in names])
        assert "steps" in names and host.get("steps") == 17
        assert bytes.fromhex(host.get("outputs.packed")) == wanted
        packed, say = (host.vars[name].valueReference for name in ("outputs.packed", "say"))
        texts = host.fmu.getString([say, packed, say])
        assert bytes.fromhex(texts[1].decode()) == wanted and texts[0] == texts[2] != texts[1]
        state = host.fmu.getFMUstate(); before = host.fmu.serializeFMUstate(state)
        host.get("outputs.packed"); host.fmu.freeFMUstate(state)
        state = host.fmu.getFMUstate(); assert host.fmu.serializeFMUstate(state) == before
        host.fmu.freeFMUstate(state); host.close()
    """)


def test_state_saved_and_set_gives_the_same_bits():
    run("""
        host = Host(F).initialize(force=3.0, spring__law="cubic"); host.step(17)
        state = host.fmu.getFMUstate(); host.step(30); wanted = host.outputs()
        for _ in range(2):
            host.time = 0.017; host.fmu.setFMUstate(state); host.step(30)
            assert host.outputs() == wanted, (host.outputs(), wanted)
        host.set(error="step"); assert host.step() == 4
        host.time = 0.017; host.fmu.setFMUstate(state); assert host.step(30) is None
        assert host.outputs() == wanted and host.get("status.message") == ""
        host.fmu.freeFMUstate(state); host.close()
    """)


def test_state_goes_to_another_process(tmp_path):
    file = tmp_path / "state"
    wanted = run(
        """
        host = Host(F).initialize(force=3.0, mass=7.0, spring__law="cubic"); host.step(17)
        state = host.fmu.getFMUstate(); data = host.fmu.serializeFMUstate(state)
        assert data == host.fmu.serializeFMUstate(host.fmu.deSerializeFMUstate(data))
        open(sys.argv[2], "wb").write(data); host.step(30)
        print(*map(ascii, host.outputs())); host.close()
        """,
        file,
    )
    for prepare in ("", "host.initialize()", "host.initialize(mass=8.0); host.step(3)"):
        found = run(
            f"""
            host = Host(F); {prepare}
            host.fmu.setFMUstate(host.fmu.deSerializeFMUstate(open(sys.argv[2], "rb").read()))
            host.time = 0.017; host.step(30); print(*map(ascii, host.outputs())); host.close()
            """,
            file,
        )
        assert found == wanted, prepare


def test_damaged_or_foreign_state_is_refused():
    run(
        """
        def refused(host, data):
            assert host.refusal("setFMUstate", host.fmu.deSerializeFMUstate(data)) == 4
            assert host.step() == 4; text = host.texts(4)[-1]; host.close(); return text
        host = Host(F).initialize(); state = host.fmu.getFMUstate()
        data = host.fmu.serializeFMUstate(state); host.close()
        for i in range(0, len(data), 97):
            bad = bytearray(data); bad[i] ^= 1
            text = refused(Host(F, f"bad{i}").initialize(), bytes(bad))
            assert any(w in text for w in ("damaged", "not a saved state", "version")), text
        assert "not a saved state" in refused(Host(F, "short").initialize(), data[:50])
        other = Host(sys.argv[2], "other").initialize()
        assert "saved by another model or version" in refused(other, data)
        """,
        doubler_fmu(),
    )


def test_two_fmus_share_the_base():
    run(
        """
        one, two = Host(F).initialize(force=2.0), Host(sys.argv[2], "two").initialize()
        for _ in range(5):
            two.set(u=one.get("position")); one.step(); two.step()
            assert two.get("y") == 2.0 * one.get("position") != 0.0 or one.get("steps") == 1
        two.close(); assert one.step() is None; one.close()
        """,
        doubler_fmu(),
    )


@pytest.fixture
def newer_base(tmp_path, monkeypatch):
    """Build the doubler with another version of ``rail_fmi``."""
    import rail_fmi

    mass_spring_fmu()  # built with the usual base, before the other one takes its place
    copy = tmp_path / "newer"
    shutil.copytree(rail_fmi.__path__[0], copy / "rail_fmi")
    with (copy / "rail_fmi" / "errors.py").open("a") as file:
        file.write("\n# 100 % newer\n")
    monkeypatch.setattr("rail_fmi.builder._package_folder", _prefer(copy))
    script = tmp_path / "doubler_fmu.py"
    script.write_text(SECOND_ENTRY)
    return build_fmu(script, PACKAGES[:2], tmp_path)


def _prefer(copy):
    from rail_fmi.builder import _package_folder as usual

    return lambda name: copy / name if (copy / name).is_dir() else usual(name)


def test_another_version_of_a_loaded_package_is_refused_by_name(newer_base):
    lines = run(
        """
        host = Host(F).initialize()
        try:
            Host(sys.argv[2], "newer")
        except Exception as error:
            print(error)
        from fmu_host import _log
        print("package 'rail_fmi' is already loaded from" in _log["newer"][0][1])
        assert host.step() is None; host.close()
        """,
        newer_base,
    )
    assert lines == ["Failed to instantiate model", "True"]


def test_differing_installed_copy_is_refused_by_name(tmp_path):
    (tmp_path / "mass_spring").mkdir()
    (tmp_path / "mass_spring" / "__init__.py").write_text("")
    done = run_process(
        "import mass_spring; from fmu_host import Host; import sys; Host(sys.argv[1])",
        mass_spring_fmu(),
        paths=(tmp_path,),
    )
    assert done.returncode == 1
    assert "package 'mass_spring' is already loaded from" in done.stderr
    assert "process can hold only one" in done.stderr


def test_equal_installed_copy_is_used():
    run(
        "import mass_spring\nhost = Host(F).initialize(); assert host.step() is None; host.close()"
        "\nassert mass_spring.__file__.startswith(sys.argv[2])",
        SUPPORT,
    )
