"""Animation of a run: vehicle, bending rails, slabs, and the sliding window."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter

from rail_cosim.animation.drawing import Stage, default_exaggeration
from rail_cosim.animation.film import FRAME_RATE, OPTION, PROFILES_WANTED, Film, check_track
from rail_cosim.errors import ParameterError, ResultsError
from rail_cosim.results import check_writable

if TYPE_CHECKING:
    from rail_cosim.reporter import Reporter

__all__ = [
    "FORMATS",
    "PROFILES_WANTED",
    "Film",
    "check_animation",
    "check_track",
    "write_animation",
]

FORMATS = (".mp4", ".gif")
_DOTS = {".mp4": 100, ".gif": 60}  # per inch


def check_animation(path: Path) -> None:
    """Make sure before a run that an animation can be written at ``path``.

    Raises
    ------
    ParameterError
        For another ending than .mp4 and .gif, and for .mp4 without ffmpeg.
    ResultsError
        If the file cannot be written there.
    """
    if path.suffix.lower() not in FORMATS:
        raise ParameterError(OPTION, str(path), "must end in " + " or ".join(FORMATS))
    if path.suffix.lower() == ".mp4":
        ffmpeg()
    check_writable(path)


def ffmpeg() -> str:
    """Return the program ffmpeg: of the system, else of the package imageio-ffmpeg.

    Raises
    ------
    ParameterError
        If there is neither.
    """
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return get_ffmpeg_exe()
    except (ImportError, RuntimeError) as error:
        raise ParameterError(
            OPTION,
            ".mp4",
            "needs ffmpeg, which is not installed",
            "pip install 'rail-cosim[video]', or install ffmpeg, or write a .gif",
        ) from error


def write_animation(
    film: Film, path: Path, reporter: Reporter, *, exaggeration: float | None = None
) -> None:
    """Draw all frames of an animation into a file.

    Parameters
    ----------
    film
        What was recorded, one frame or more.
    path
        Ending in .mp4 or .gif.
    reporter
        Told how many frames are drawn.
    exaggeration
        Of vertical displacements; None: a round number that makes the rail deflection visible.

    Raises
    ------
    ResultsError
        If it cannot be written.
    """
    count = len(film.times)
    if count == 0:
        raise ResultsError(f"{path}: there is no frame to draw; the run ended before its start")
    stage = Stage(film, exaggeration or default_exaggeration(film))
    reporter.stage(f"drawing {path}")
    settings, writer = _writer(path)
    try:
        with (
            matplotlib.rc_context(settings),
            writer.saving(stage.figure, str(path), _DOTS[path.suffix.lower()]),
        ):
            for number in range(count):
                stage.show(number)
                writer.grab_frame()
                reporter.progress(number + 1, count)
    except (OSError, RuntimeError) as error:
        raise ResultsError(f"{path}: the animation could not be written ({error})") from error


def _writer(path: Path) -> tuple[dict[Any, Any], AbstractMovieWriter]:
    if path.suffix.lower() == ".gif":
        return {}, PillowWriter(fps=int(FRAME_RATE))
    # Players want this pixel format.
    arguments = ["-pix_fmt", "yuv420p"]
    settings: dict[Any, Any] = {"animation.ffmpeg_path": ffmpeg()}
    with matplotlib.rc_context(settings):
        return settings, FFMpegWriter(fps=int(FRAME_RATE), codec="h264", extra_args=arguments)
