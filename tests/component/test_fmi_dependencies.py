"""What the FMUs declare to depend on what, against what does, by perturbation."""

import numpy as np
import pytest
from rail_vehicle.slave import VehicleSlave
from slab_track.slave import TrackSlave

SIZES = {"m": 1e-6, "rad": 1e-6, "m/s": 1e-2, "rad/s": 1e-2, "N": 100.0, "N.m": 100.0}


class Probe:
    """A slave in initialization mode, its real unknowns, and the inputs each one declares."""

    def __init__(self, kind, **values):
        self.slave = kind(instance_name="probe", resources=None)
        self.slave.enter_initialization_mode()
        self.slave.values.update({k.replace("__", "."): v for k, v in values.items()})
        root, table = self.slave.to_xml(), list(self.slave.table.values())
        self.inputs = [v.name for v in table if v.causality == "input" and v.kind == "real"]
        self.parameters = {v.name for v in table if v.causality == "parameter"}
        self.outputs = root.findall("ModelStructure/Outputs/Unknown")
        self.known = {}
        for unknown in root.find("ModelStructure/InitialUnknowns"):
            variable = table[int(unknown.get("index")) - 1]
            if variable.kind == "real":
                indices = unknown.get("dependencies").split()
                self.known[variable.name] = {table[int(i) - 1].name for i in indices}
        self.at = self.slave.indices(self.inputs).tolist()
        self.unknowns = self.slave.indices(list(self.known)).tolist()
        self.start = self.read()  # lets inputs that are not set follow the parameters
        self.given = np.array(self.slave.get_real(self.at))

    def read(self):
        values = np.array(self.slave.get_real(self.unknowns))
        assert self.slave.held_error == ""
        return values

    def changed(self, names, factor=1.0):
        """Return the unknowns that other values of these inputs change."""
        step = np.array([SIZES[self.slave.table[name].unit] for name in self.inputs])
        step *= np.where([name in names for name in self.inputs], factor, 0.0)
        step *= 1.0 + 0.1 * np.arange(len(step)) / len(step)  # so that nothing cancels
        self.slave.set_real(self.at, (self.given + step).tolist())
        changed = self.read() != self.start
        self.slave.set_real(self.at, self.given.tolist())
        return {name for name, moved in zip(self.known, changed, strict=True) if moved}


SETTINGS = [
    pytest.param(VehicleSlave, {}, id="vehicle"),
    pytest.param(TrackSlave, {}, id="track"),
    pytest.param(TrackSlave, {"interface": "applied_force"}, id="track-applied-force"),
]


@pytest.mark.parametrize(("kind", "values"), SETTINGS)
def test_nothing_depends_on_what_is_not_declared(kind, values):
    probe = Probe(kind, **values)
    sets = {frozenset(names) for names in probe.known.values()}
    for declared in sets:
        others = set(probe.inputs) - declared
        assert not probe.changed(others) & {n for n, d in probe.known.items() if d == declared}
        assert declared >= probe.parameters  # a superset, which FMI allows


def test_what_is_declared_acts():
    """All of it at once; what follows from the positions alone does so in slab lengths."""
    for kind in (VehicleSlave, TrackSlave):
        probe = Probe(kind)
        declared = {name for name, known in probe.known.items() if known & set(probe.inputs)}
        assert probe.changed(set(probe.inputs)) == declared - {"window.start_position"}


@pytest.mark.parametrize("kind", [VehicleSlave, TrackSlave])
def test_between_steps_no_output_depends_on_an_input(kind):
    probe = Probe(kind)
    assert [unknown.get("dependencies") for unknown in probe.outputs] == [""] * len(probe.outputs)
    probe.slave.exit_initialization_mode()
    assert not probe.changed(set(probe.inputs))
