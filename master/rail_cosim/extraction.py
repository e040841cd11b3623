"""Extract an FMU once, to a directory keyed by its GUID and its content."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import tempfile
from pathlib import Path

from rail_cosim.archives import is_whole, opened, unpack
from rail_cosim.cache import VARIABLE, plain_directory
from rail_cosim.errors import FmuFileError


def extract(path: Path, guid: str) -> Path:
    """Return the directory with the extracted FMU, extracting it if it is not there yet.

    The name holds the GUID and a hash of the file, so that the same FMU is
    always found at the same place (its own caches hit) and a changed one never
    is. Several processes may do this at once: a directory appears complete or
    not at all. One that was damaged since is found by its checksums and made anew.

    Raises
    ------
    FmuFileError
        If the file is no zip archive, must not be unpacked (see
        :mod:`rail_cosim.archives`), or cannot be.
    """
    with opened(path) as archive:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        key = re.sub(r"[^0-9A-Za-z-]", "", guid)[:40]
        root = plain_directory() / "extracted"
        target = root / f"{key}-{digest}"
        if target.is_dir():
            if is_whole(archive, target):
                return target
            _set_aside(target)
        root.mkdir(exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".extracting-", dir=root))
        try:
            unpack(archive, scratch)
            scratch.chmod(0o755)
            os.rename(scratch, target)
        except OSError as error:
            # Else another process was first, with the same content.
            if not target.is_dir():
                raise FmuFileError(
                    f"{path}: it cannot be extracted to {root} ({error.strerror or error}); make "
                    f"room there, or set {VARIABLE} to another folder"
                ) from error
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
        return target


def _set_aside(target: Path) -> None:
    """Move a damaged folder out of the way; where it was, the next one appears complete."""
    grave = Path(tempfile.mkdtemp(prefix=".damaged-", dir=target.parent))
    with contextlib.suppress(OSError):
        os.rename(target, grave / "entry")
    shutil.rmtree(grave, ignore_errors=True)
