"""What a run returns: its Dataset, with methods that plot it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import xarray as xr

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BOX = "axle_box_vertical_acceleration"


class HistoryOptions(TypedDict, total=False):
    """What a plot of a history takes; see :class:`RunResult`."""

    versus: str
    wheelset: int | None
    side: str
    ax: Axes | None


class RunResult(xr.Dataset):
    """The Dataset of a run, which can plot itself.

    It is an :class:`xarray.Dataset` in all else; what selects from it (``isel``, ``sel``) gives a
    result again. All methods draw every record with matplotlib and return the axes. Their options:

    - ``versus``: ``"distance"`` (travelled by the leading wheelset, m; the default) or ``"time"``
      (s);
    - ``wheelset``: a number from 1 on; all unless given;
    - ``side``: ``"left"`` (the default), ``"right"`` or ``"both"``;
    - ``ax``: the axes to draw in; a new figure unless given.

    What the run does not have is refused with a :class:`~rail_cosim.errors.ParameterError`.

    >>> result = rail_cosim.run(distance=20.0, irregularity="rail_joint")  # doctest: +SKIP
    >>> result.plot_wheel_force(wheelset=1, versus="time")  # doctest: +SKIP
    """

    __slots__ = ()

    @classmethod
    def of(cls, dataset: xr.Dataset) -> RunResult:
        """Return a run's Dataset as a result; they share their data."""
        found = cls(dict(dataset.data_vars), coords=dataset.coords, attrs=dataset.attrs)
        found.set_close(dataset.close)
        return found

    def plot_history(self, variable: str, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot any variable over the run.

        Parameters
        ----------
        variable
            Its name; it has the dimension ``time``.
        """
        from rail_cosim.result_plots import draw_history

        return draw_history(self, variable, **options)

    def plot_wheel_force(self, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot the wheel forces, normal to the contact, in kN."""
        return self.plot_history("normal_force", **options)

    def plot_lateral_wheel_force(self, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot the lateral wheel forces Y in kN."""
        return self.plot_history("guiding_force", **options)

    def plot_track_shifting_force(self, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot the track shifting force of each wheelset, the sum of its Y, in kN."""
        return self.plot_history("track_shifting_force", **options)

    def plot_axle_box_acceleration(self, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot the vertical axle-box accelerations in m/s2."""
        return self.plot_history(_BOX, **options)

    def plot_rail_deflection(self, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot the vertical displacements of the rails under the wheels in mm."""
        return self.plot_history("rail_vertical_displacement", **options)

    def plot_wheelset_displacement(self, **options: Unpack[HistoryOptions]) -> Axes:
        """Plot the vertical displacements of the wheelsets in mm."""
        return self.plot_history("wheelset_vertical_displacement", **options)

    def plot_bogie_acceleration(
        self, direction: str = "vertical", **options: Unpack[HistoryOptions]
    ) -> Axes:
        """Plot the accelerations of the bogies in m/s2.

        Parameters
        ----------
        direction
            ``vertical`` or ``lateral``.
        """
        return self.plot_history(f"bogie_{direction}_acceleration", **options)

    def plot_car_body_acceleration(
        self, direction: str = "vertical", **options: Unpack[HistoryOptions]
    ) -> Axes:
        """Plot the acceleration of the car body in m/s2.

        Parameters
        ----------
        direction
            ``vertical`` or ``lateral``.
        """
        return self.plot_history(f"car_body_{direction}_acceleration", **options)

    def plot_spectrum(
        self,
        variable: str = _BOX,
        *,
        window: tuple[float, float] | None = None,
        wheelset: int | None = None,
        side: str = "left",
        ax: Axes | None = None,
    ) -> Axes:
        """Plot the amplitude spectrum of a variable over a window, which the title states.

        Parameters
        ----------
        variable
            Any with the dimension ``time``.
        window
            Distances travelled from and to, m; the run's evaluation window unless given.
        wheelset, side, ax
            As for all plots.
        """
        from rail_cosim.result_plots import draw_spectrum

        return draw_spectrum(self, variable, window=window, wheelset=wheelset, side=side, ax=ax)


def open_result(path: str | Path) -> RunResult:
    """Open the NetCDF file of a run; its data are read when they are used.

    Parameters
    ----------
    path
        A file that ``rail-cosim run --out`` or ``rail_cosim.run(out=...)`` wrote.

    Returns
    -------
    RunResult
        As :func:`rail_cosim.run` returns it; close it, or use it in a ``with`` statement.

    Raises
    ------
    ReportError
        If there is no such file, or it is not a run.
    """
    from rail_cosim.reporting.reading import open_dataset

    return RunResult.of(open_dataset(Path(path)))
