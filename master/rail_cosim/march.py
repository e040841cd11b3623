"""Macro steps of FMUs in C: the same calls in the same order, without Python between.

A macro step makes some seven calls of FMI functions; the interpreter's own work between them and
around each of them costs about as much as a call does. So a block of steps runs in ``loop.c``,
which calls the FMUs' functions by their addresses. It does what
:class:`rail_cosim.algorithms.GaussSeidel` or :class:`rail_cosim.algorithms.Jacobi`, the recorder
and the energy's observer do in Python, value for value; those remain for slaves that are no FMUs,
for the iterative algorithm, and where something is set from outside in every step.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from rail_cosim import packed
from rail_cosim.core import core
from rail_cosim.exchange import Port
from rail_cosim.fmu import FmuSlave, FmuVector
from rail_cosim.recorder import Recorder
from rail_cosim.system import SystemStructure

Array = NDArray[np.float64]
LONGEST = 200
"""Steps in one go: between two of them the user's Ctrl-C is noticed."""
LARGEST_VALUE = 1e12
"""No exchanged quantity comes near this in SI units."""

_CALLS = ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal", "fmi2GetInteger", "fmi2GetString")
_DIVERGED = len(_CALLS)

_POINTER, _LONG = ctypes.c_void_p, ctypes.c_int64


class _Fmu(ctypes.Structure):
    """``Fmu`` of loop.c."""

    _fields_ = [
        ("component", _POINTER),
        ("do_step", _POINTER),
        ("rolls_back", _LONG),
        ("set_real", _POINTER),
        ("inputs", _POINTER),
        ("input_count", _LONG),
        ("input_values", _POINTER),
        ("sources", _POINTER),
        ("get_real", _POINTER),
        ("outputs", _POINTER),
        ("output_count", _LONG),
        ("coupled_count", _LONG),
        ("output_values", _POINTER),
        ("get_integer", _POINTER),
        ("counters", _POINTER),
        ("counter_count", _LONG),
        ("counter_values", _POINTER),
        ("get_string", _POINTER),
        ("text", _POINTER),
        ("text_count", _LONG),
        ("text_reals", _POINTER),
        ("text_counters", _POINTER),
    ]


class _Recording(ctypes.Structure):
    """``Recording`` of loop.c."""

    _fields_ = [
        ("every", _LONG),
        ("width", _LONG),
        ("real_count", _LONG),
        ("counter_count", _LONG),
        ("watched_count", _LONG),
        ("reals", _POINTER),
        ("watched", _POINTER),
        ("counters", _POINTER),
        ("real_columns", _POINTER),
        ("counter_columns", _POINTER),
        ("records", _POINTER),
        ("seen", _POINTER),
    ]


class _End(ctypes.Structure):
    """``End`` of loop.c."""

    _fields_ = [(name, _LONG) for name in ("done", "recorded", "fmu", "call", "status")]


class March:
    """Steps the FMUs of a system in C.

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
    text_counts
        How many numbers each FMU gives as one text.
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
        self._slaves = [cast(FmuSlave, port.slave) for port in system.ports]
        self._kept: list[Any] = []
        self._records = np.empty((LONGEST, recorder.width))
        self._seen = np.empty((LONGEST, len(watched)))
        first = 0
        fmus = []
        for port in system.ports:
            count = len(port.inputs.names)
            fmus.append(self._described(port, system.sources[first : first + count]))
            first += count
        self._fmus = (_Fmu * len(fmus))(*fmus)
        self.text_counts = [fmu.text_count for fmu in fmus]
        self._recording = self._described_recording(watched)
        self._call = core.library.rail_cosim_steps
        self._call.restype = None
        self.finished = 0, self._seen[:0]

    def _array(self, values: Iterable[Any], dtype: Any = np.int64) -> int:
        """Keep an array in memory and return its address."""
        array = np.ascontiguousarray(list(values), dtype=dtype)
        self._kept.append(array)
        return array.ctypes.data

    def _described(self, port: Port, sources: NDArray[np.intp]) -> _Fmu:
        slave, fmu = cast(FmuSlave, port.slave), _Fmu()
        fmu.component, fmu.do_step = slave.addresses()
        _, fmu.set_real, fmu.inputs, fmu.input_values = _addresses(port.inputs)
        fmu.get_real, _, fmu.outputs, fmu.output_values = _addresses(port.outputs)
        fmu.get_integer, _, fmu.counters, fmu.counter_values = _addresses(port.counters)
        fmu.input_count, fmu.sources = len(port.inputs.names), self._array(sources)
        fmu.output_count, fmu.coupled_count = len(port.outputs.names), port.coupled
        fmu.counter_count = len(port.counters.names)
        names = packed.names(port)
        if names:
            fmu.get_string = slave.address("fmi2GetString")
            fmu.text = self._array([slave.variables[packed.NAME].reference], np.uint32)
            fmu.text_count = len(names)
            places = [_place(port.outputs, name) for name in names]
            fmu.text_reals = self._array(places, np.uintp)
            places = [_place(port.counters, name) for name in names]
            fmu.text_counters = self._array(places, np.uintp)
        return fmu

    def _described_recording(self, watched: NDArray[np.intp]) -> _Recording:
        system, to = self._system, _Recording()
        board, counters = system.board, system.counters
        real_columns, counter_columns = self._recorder.places()
        to.every, to.width = self._recorder.every, self._recorder.width
        to.real_count, to.counter_count = len(real_columns), len(counter_columns)
        to.watched_count = len(watched)
        to.reals = self._array(board.ctypes.data + 8 * np.arange(board.size), np.uintp)
        to.watched = self._array(board.ctypes.data + 8 * np.asarray(watched), np.uintp)
        to.counters = self._array(counters.ctypes.data + 4 * np.arange(counters.size), np.uintp)
        to.real_columns = self._array(real_columns)
        to.counter_columns = self._array(counter_columns)
        to.records, to.seen = self._records.ctypes.data, self._seen.ctypes.data
        return to

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
        for fmu, slave in zip(self._fmus, self._slaves, strict=True):
            fmu.rolls_back = slave.rolls_back
        end = _End()
        self._call(
            self._fmus,
            _LONG(len(self._fmus)),
            _POINTER(self._system.board.ctypes.data),
            _LONG(done),
            _LONG(count),
            ctypes.c_double(step_size),
            _LONG(self._sequential),
            ctypes.byref(self._recording),
            ctypes.byref(end),
        )
        self._recorder.append(self._records[: end.recorded])
        self.finished = end.done, self._seen[: end.done - done]
        for slave in self._slaves:
            slave.time = end.done * step_size
        if end.fmu >= 0 and end.call != _DIVERGED:
            self._slaves[end.fmu].fail(_CALLS[end.call], end.status)
        return self.finished


def _addresses(vector: Any) -> tuple[int, int, int, int]:
    return cast(FmuVector, vector).addresses()


def _place(vector: Any, name: str) -> int:
    """Return where a value of a vector is in memory; 0 if it is not in it."""
    if name not in vector.names:
        return 0
    return vector.values[vector.names.index(name) :].ctypes.data
