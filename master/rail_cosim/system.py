"""The system structure: which slaves there are and how they are connected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rail_cosim.connections import Connection, Unconnected, connect
from rail_cosim.exchange import Link, Port
from rail_cosim.slave import Slave, Vector


class SystemStructure:
    """Slaves connected by equal names of outputs and inputs.

    Attributes
    ----------
    slaves
        In the order in which a sequential algorithm steps them.
    connections, unconnected
        What is connected, and the inputs that nothing feeds.
    ports
        One per slave, in the same order.
    board, feeds, counters
        All ports' real outputs, inputs and integer outputs one after the other: the memory of
        the ports' buffers.
    sources
        For each place in ``feeds`` the place in ``board`` that it is connected with.

    Raises
    ------
    StructureError
        If the slaves do not fit together (see :func:`rail_cosim.connections.connect`).
    """

    def __init__(self, slaves: Sequence[Slave]) -> None:
        self.slaves = tuple(slaves)
        self.connections: list[Connection]
        self.unconnected: list[Unconnected]
        self.connections, self.unconnected = connect(
            {slave.name: slave.variables for slave in slaves}
        )
        self.ports = tuple(self._port(slave) for slave in slaves)
        self.board = _together([port.outputs for port in self.ports], np.float64)
        self.feeds = _together([port.inputs for port in self.ports], np.float64)
        self.counters = _together([port.counters for port in self.ports], np.int32)
        self.sources = self._sources()
        for port in self.ports:
            port.links.extend(self._links(port))

    def __getitem__(self, name: str) -> Slave:
        return next(slave for slave in self.slaves if slave.name == name)

    def port(self, name: str) -> Port:
        """Return the port of the slave with this name."""
        return next(port for port in self.ports if port.slave.name == name)

    def _port(self, slave: Slave) -> Port:
        # In the slave's own order: consecutive variables are cheaper to reach.
        order = {name: place for place, name in enumerate(slave.variables)}
        inputs = sorted(
            (c.name for c in self.connections if c.target == slave.name), key=order.__getitem__
        )
        sources = {c.name for c in self.connections if c.source == slave.name}
        coupled = sorted(sources, key=order.__getitem__)
        outputs = [v for v in slave.variables.values() if v.causality == "output"]
        reals = [v.name for v in outputs if v.kind == "real"]
        others = [name for name in reals if name not in set(coupled)]
        counters = [v.name for v in outputs if v.kind == "integer"]
        return Port(
            slave=slave,
            inputs=slave.vector(inputs),
            outputs=slave.vector(coupled + others),
            counters=slave.vector(counters, "integer"),
            coupled=len(coupled),
        )

    def place_of(self, slave: str, name: str) -> int:
        """Return where a real output is on the board."""
        first = 0
        for port in self.ports:
            if port.slave.name == slave:
                return first + port.outputs.names.index(name)
            first += len(port.outputs.names)
        raise KeyError(slave)

    def _sources(self) -> NDArray[np.intp]:
        sources = {(c.target, c.name): c.source for c in self.connections}
        return np.array(
            [
                self.place_of(sources[port.slave.name, name], name)
                for port in self.ports
                for name in port.inputs.names
            ],
            dtype=np.intp,
        )

    def _links(self, target: Port) -> list[Link]:
        links: list[Link] = []
        for source in self.ports:
            names = [
                c.name
                for c in self.connections
                if c.target == target.slave.name and c.source == source.slave.name
            ]
            if names:
                where_from = [source.outputs.names.index(name) for name in names]
                where_to = [target.inputs.names.index(name) for name in names]
                links.append(
                    Link(
                        outputs=source.outputs.values,
                        source=_places(where_from),
                        target=_places(where_to),
                    )
                )
        return links


def _together(vectors: Sequence[Vector], kind: type) -> NDArray:
    """Move the buffers of vectors into one array, one after the other, and return it."""
    whole = np.zeros(sum(len(vector.names) for vector in vectors), dtype=kind)
    first = 0
    for vector in vectors:
        vector.place(whole[first : first + len(vector.names)])
        first += len(vector.names)
    return whole


def _places(positions: list[int]) -> NDArray[np.intp] | slice:
    """Return a slice for positions one after the other, which is several times as fast."""
    first = positions[0]
    if positions == list(range(first, first + len(positions))):
        return slice(first, first + len(positions))
    return np.array(positions, dtype=np.intp)
