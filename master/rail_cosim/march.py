"""Macro steps of FMUs in compiled code: the same calls in the same order, without Python between.

A macro step makes some seven calls of FMI functions; the interpreter's own work between them and
around each of them costs about as much as a call does. So a block of steps runs in one compiled
function that calls the FMUs' functions by their addresses. It does what
:class:`rail_cosim.algorithms.GaussSeidel` or :class:`rail_cosim.algorithms.Jacobi`, the recorder
and the energy's observer do in Python, value for value; those remain for slaves that are no FMUs,
for the iterative algorithm, and where something is set from outside in every step.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from rail_cosim import packed
from rail_cosim.exchange import Port
from rail_cosim.fmu import FmuSlave, FmuVector
from rail_cosim.kept_code import compiled
from rail_cosim.packed import unpack
from rail_cosim.recorder import Recorder
from rail_cosim.system import SystemStructure

Array = NDArray[np.float64]
LONGEST = 200
"""Steps in one go: between two of them the user's Ctrl-C is noticed."""
LARGEST_VALUE = 1e12
"""No exchanged quantity comes near this in SI units."""

# Columns of the table of calls, one row for each port.
_COMPONENT, _DO_STEP, _ROLLS_BACK = 0, 1, 2
_SET, _INPUTS, _INPUT_COUNT, _INPUT_VALUES = 3, 4, 5, 6
_GET, _OUTPUTS, _OUTPUT_COUNT, _COUPLED, _OUTPUT_VALUES = 7, 8, 9, 10, 11
_COUNT, _COUNTERS, _COUNTER_COUNT, _COUNTER_VALUES = 12, 13, 14, 15
_TEXT, _TEXT_REFERENCE, _TEXT_PLACE = 16, 17, 18
_WIDTH = 19
_WARNING, _ERROR = 1, 3
_CALLS = ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal", "fmi2GetInteger", "fmi2GetString")
_DIVERGED = len(_CALLS)


def _make_vector_call(
    typing: Any, address: Any, component: Any, references: Any, count: Any, values: Any
) -> Any:
    """Call an FMI function that gets or sets values of variables; return its status."""
    signature = types.int32(types.int64, types.int64, types.int64, types.int64, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer, long = ir.IntType(8).as_pointer(), ir.IntType(64)
        kind = ir.FunctionType(ir.IntType(32), [pointer, pointer, long, pointer])
        where, *given = arguments
        function = builder.inttoptr(where, kind.as_pointer())
        given[0], given[1] = (builder.inttoptr(value, pointer) for value in given[:2])
        given[3] = builder.inttoptr(given[3], pointer)
        return builder.call(function, given)

    return signature, generate


def _make_step_call(
    typing: Any, address: Any, component: Any, time: Any, step_size: Any, rolls_back: Any
) -> Any:
    """Call fmi2DoStep; return its status."""
    signature = types.int32(types.int64, types.int64, types.float64, types.float64, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer, real = ir.IntType(8).as_pointer(), ir.DoubleType()
        kind = ir.FunctionType(ir.IntType(32), [pointer, real, real, ir.IntType(32)])
        where, component, time, step_size, rolls_back = arguments
        function = builder.inttoptr(where, kind.as_pointer())
        forward = builder.icmp_signed("==", rolls_back, ir.Constant(ir.IntType(64), 0))
        flag = builder.zext(forward, ir.IntType(32))
        return builder.call(function, [builder.inttoptr(component, pointer), time, step_size, flag])

    return signature, generate


_vector_call: Any = intrinsic(_make_vector_call)
_step_call: Any = intrinsic(_make_step_call)


@compiled
def _set_inputs(call: Any, feeds: Array, board: Array, sources: Any, first: int) -> int:
    for index in range(call[_INPUT_COUNT]):
        feeds[first + index] = board[sources[first + index]]
    if call[_INPUT_COUNT] == 0:
        return 0
    return _vector_call(
        call[_SET], call[_COMPONENT], call[_INPUTS], call[_INPUT_COUNT], call[_INPUT_VALUES]
    )


@compiled
def _read_text(call: Any, text: Any, targets: Any, bits: Any, board: Array, counters: Any) -> int:
    """Read all outputs of an FMU as one text, (n,) numbers with places ``targets`` (n,)."""
    status = _vector_call(
        call[_TEXT], call[_COMPONENT], call[_TEXT_REFERENCE], 1, call[_TEXT_PLACE]
    )
    if status > _WARNING:
        return status
    if text[0] == 0 or not unpack(text[0], bits):
        return _ERROR
    values = bits.view(np.float64)
    for index in range(len(targets)):
        if targets[index] >= 0:
            board[targets[index]] = values[index]
        else:
            counters[-1 - targets[index]] = np.int32(values[index])
    return status


@compiled
def _march(
    calls: Any,
    firsts: Any,
    sources: Any,
    feeds: Array,
    board: Array,
    counters: Any,
    done: int,
    count: int,
    step_size: float,
    sequential: bool,
    every: int,
    records: Array,
    real_columns: Any,
    counter_columns: Any,
    watched: Any,
    seen: Array,
    places: Any,
    texts: Any,
    targets: Any,
    ends: Any,
    bits: Any,
) -> tuple[int, int, int, int, int]:
    """Do ``count`` steps; return steps done, records made, and a failing port, call and status."""
    recorded = 0
    for step in range(done + 1, done + count + 1):
        time = (step - 1) * step_size
        due = step % every == 0
        if not sequential:
            for port in range(len(calls)):
                status = _set_inputs(calls[port], feeds, board, sources, firsts[port])
                if status > _WARNING:
                    return step - 1, recorded, port, 0, status
        for port in range(len(calls)):
            call = calls[port]
            if sequential:
                status = _set_inputs(call, feeds, board, sources, firsts[port])
                if status > _WARNING:
                    return step - 1, recorded, port, 0, status
            status = _step_call(
                call[_DO_STEP], call[_COMPONENT], time, step_size, call[_ROLLS_BACK]
            )
            if status > _WARNING:
                return step - 1, recorded, port, 1, status
            numbers = ends[port + 1] - ends[port] if due else 0
            if numbers > 0:
                status = _read_text(
                    call,
                    texts[port : port + 1],
                    targets[ends[port] : ends[port + 1]],
                    bits[:numbers],
                    board,
                    counters,
                )
                if status > _WARNING:
                    return step - 1, recorded, port, 4, status
            wanted = call[_OUTPUT_COUNT] if due else call[_COUPLED]
            if numbers == 0 and wanted > 0:
                status = _vector_call(
                    call[_GET], call[_COMPONENT], call[_OUTPUTS], wanted, call[_OUTPUT_VALUES]
                )
                if status > _WARNING:
                    return step - 1, recorded, port, 2, status
            for index in range(places[port], places[port] + call[_COUPLED]):
                if not abs(board[index]) < LARGEST_VALUE:
                    return step - 1, recorded, port, _DIVERGED, 0
            if due and numbers == 0 and call[_COUNTER_COUNT] > 0:
                status = _vector_call(
                    call[_COUNT],
                    call[_COMPONENT],
                    call[_COUNTERS],
                    call[_COUNTER_COUNT],
                    call[_COUNTER_VALUES],
                )
                if status > _WARNING:
                    return step - 1, recorded, port, 3, status
        row = seen[step - done - 1]
        for index in range(len(watched)):
            row[index] = board[watched[index]]
        if due:
            record = records[recorded]
            record[0] = step * step_size
            for index in range(len(board)):
                record[real_columns[index]] = board[index]
            for index in range(len(counters)):
                record[counter_columns[index]] = counters[index]
            recorded += 1
    return done + count, recorded, -1, 0, 0


class March:
    """Steps the FMUs of a system in compiled code.

    Parameters
    ----------
    system
        Of slaves that are all :class:`rail_cosim.fmu.FmuSlave`.
    sequential
        Whether each slave gets the newest outputs of those before it (Gauss-Seidel) or all get
        those of the step before (Jacobi).
    recorder
        Gets the records.
    watched
        Positions in ``system.board`` of the outputs that are wanted after each step.

    Attributes
    ----------
    finished
        What :meth:`run` returned, or would have returned had it not raised.
    """

    def __init__(
        self,
        system: SystemStructure,
        *,
        sequential: bool,
        recorder: Recorder,
        watched: NDArray[np.intp],
    ) -> None:
        self._system, self._sequential, self._recorder = system, sequential, recorder
        self._watched = watched
        slaves = [cast(FmuSlave, port.slave) for port in system.ports]
        self._slaves = slaves
        self._calls = np.array([_row(port) for port in system.ports], dtype=np.int64)
        counts = [len(port.inputs.names) for port in system.ports]
        self._firsts = np.cumsum([0, *counts[:-1]])
        self._sources = system.sources
        first = system.board.ctypes.data
        self._places = np.array(
            [(p.outputs.values.ctypes.data - first) // 8 for p in system.ports], dtype=np.int64
        )
        self._find_texts()
        self._real_columns, self._counter_columns = recorder.places()
        self._records = np.empty((LONGEST, recorder.width))
        self._seen = np.empty((LONGEST, len(watched)))
        self.finished = 0, self._seen[:0]
        self._steps(0, 0, 1.0)  # compiles it, before time matters

    def _find_texts(self) -> None:
        """Find which FMUs give their outputs as one text, and what of it goes where."""
        counts = [len(port.counters.names) for port in self._system.ports]
        counters = np.cumsum([0, *counts])
        targets = [
            packed.targets(port, int(first), int(counter))
            for port, first, counter in zip(
                self._system.ports, self._places, counters[:-1], strict=True
            )
        ]
        self._ends = np.cumsum([0, *map(len, targets)])
        self._targets = np.concatenate([np.zeros(0, dtype=np.int64), *targets])
        self._texts = np.zeros(len(targets), dtype=np.int64)
        self._bits = np.zeros(max(map(len, targets), default=0), dtype=np.uint64)
        self._text_references = np.zeros(len(targets), dtype=np.uint32)
        for place, (row, slave) in enumerate(zip(self._calls, self._slaves, strict=True)):
            if len(targets[place]):
                self._text_references[place] = slave.variables[packed.NAME].reference
                row[_TEXT] = slave.address("fmi2GetString")
                row[_TEXT_REFERENCE] = self._text_references[place:].ctypes.data
                row[_TEXT_PLACE] = self._texts[place:].ctypes.data

    def _steps(self, done: int, count: int, step_size: float) -> tuple[int, int, int, int, int]:
        return _march(
            self._calls,
            self._firsts,
            self._sources,
            self._system.feeds,
            self._system.board,
            self._system.counters,
            done,
            count,
            step_size,
            self._sequential,
            self._recorder.every,
            self._records,
            self._real_columns,
            self._counter_columns,
            self._watched,
            self._seen,
            self._places,
            self._texts,
            self._targets,
            self._ends,
            self._bits,
        )

    def run(self, done: int, count: int, step_size: float) -> tuple[int, Array]:
        """Do up to :data:`LONGEST` steps after ``done``; record what is due.

        It stops before the step in which a slave gives a value of :data:`LARGEST_VALUE` or more,
        or none; that value is then in the port.

        Returns
        -------
        done, watched
            Steps done in all, and the watched outputs after each of these steps, shape
            (steps, watched).

        Raises
        ------
        SlaveError
            When a slave returns a status that ends the run. The steps before are then in
            :attr:`finished` and recorded.
        """
        for row, slave in zip(self._calls, self._slaves, strict=True):
            row[_ROLLS_BACK] = slave.rolls_back
        reached, recorded, port, call, status = self._steps(done, count, step_size)
        self._recorder.append(self._records[:recorded])
        self.finished = reached, self._seen[: reached - done]
        for slave in self._slaves:
            slave.time = reached * step_size
        if port >= 0 and call != _DIVERGED:
            self._slaves[port].fail(_CALLS[call], status)
        return self.finished


def _row(port: Port) -> list[int]:
    """Return the addresses and counts of the calls of one port."""
    slave = cast(FmuSlave, port.slave)
    row = [0] * _WIDTH
    row[_COMPONENT], row[_DO_STEP] = slave.addresses()
    for first, vector in (
        (_SET, port.inputs),
        (_GET, port.outputs),
        (_COUNT, port.counters),
    ):
        getter, setter, references, values = cast(FmuVector, vector).addresses()
        row[first] = setter if vector is port.inputs else getter
        row[first + 1], row[first + 2] = references, len(vector.names)
        row[first + 4 if vector is port.outputs else first + 3] = values
    row[_COUPLED] = port.coupled
    return row
