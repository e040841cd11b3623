"""Records on disk while a run goes on: rows of numbers, one after the other, and nothing else."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rail_cosim.errors import ResultsError

try:
    import fcntl
except ImportError:  # Windows: there the file itself cannot be opened twice for writing over it
    fcntl = None

Array = NDArray[np.float64]


class Spool:
    """A file of rows of float64, which one process at a time appends to.

    Parameters
    ----------
    path
        The file; its folder must exist.
    width
        Numbers in a row.
    rows
        How many rows of an existing file to keep; 0 begins a new one.

    Raises
    ------
    ResultsError
        If the file cannot be opened, is in use by another run, or has fewer rows.
    """

    def __init__(self, path: Path, width: int, *, rows: int = 0) -> None:
        self.path, self.width = path, width
        self._row_bytes = 8 * width
        self._count = rows
        try:
            self._file = open(path, "r+b" if rows else "ab", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise ResultsError(f"{path}: the records cannot be kept there ({error})") from error
        try:
            self._lock()
            if os.fstat(self._file.fileno()).st_size < rows * self._row_bytes:
                raise ResultsError(f"{path}: has fewer than the {rows} records that it should have")
            self._file.truncate(rows * self._row_bytes)
            self._file.seek(rows * self._row_bytes)
        except BaseException:
            self._file.close()
            raise

    def _lock(self) -> None:
        if fcntl is None:
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise ResultsError(
                f"{self.path}: another run is writing there; give this one another --out"
            ) from error

    def __len__(self) -> int:
        return self._count

    def append(self, rows: Array) -> None:
        """Write rows, shape (n, width), to the end.

        Raises
        ------
        ResultsError
            If they could not be written, as on a full disk; the file is then as before.
        """
        place = self._count * self._row_bytes
        try:
            left = np.ascontiguousarray(rows).data.cast("B")
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file.fileno(), place)
                self._file.seek(place)
            raise ResultsError(
                f"{self.path}: the records could not be written ({error.strerror or error}); "
                "make room there, or record less often (--record-every)"
            ) from error
        self._count += len(rows)

    def rows(self, start: int, stop: int) -> Array:
        """Return rows, shape (n, width), read from the file."""
        count = max(0, stop - start)
        with open(self.path, "rb") as file:
            file.seek(start * self._row_bytes)
            data = np.fromfile(file, dtype=np.float64, count=count * self.width)
        return data.reshape(count, self.width)

    def sync(self) -> None:
        """Make sure that what was appended survives a loss of power."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file; it stays."""
        self._file.close()
