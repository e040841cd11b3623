"""Extract an FMU once, to a directory keyed by its GUID and its content."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import zipfile
from pathlib import Path

from rail_cosim.cache import plain_directory
from rail_cosim.errors import FmuFileError


def extract(path: Path, guid: str) -> Path:
    """Return the directory with the extracted FMU, extracting it if it is not there yet.

    The name holds the GUID and a hash of the file, so that the same FMU is
    always found at the same place (its own caches hit) and a changed one never
    is. Several processes may do this at once: a directory appears complete or
    not at all.

    Raises
    ------
    FmuFileError
        If the file is no zip archive, or has members with unsafe names.
    """
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    key = re.sub(r"[^0-9A-Za-z-]", "", guid)[:40]
    root = plain_directory() / "extracted"
    target = root / f"{key}-{digest}"
    if target.is_dir():
        return target
    root.mkdir(exist_ok=True)
    scratch = Path(tempfile.mkdtemp(prefix=".extracting-", dir=root))
    try:
        _unpack(path, scratch)
        scratch.chmod(0o755)
        os.rename(scratch, target)
    except OSError:
        if not target.is_dir():  # else another process was first, with the same content
            raise
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return target


def _unpack(path: Path, directory: Path) -> None:
    try:
        with zipfile.ZipFile(path) as archive:
            for name in archive.namelist():
                if name.startswith(("/", "\\")) or ".." in Path(name).parts or ":" in name:
                    raise FmuFileError(f"{path}: the member {name!r} points out of the archive")
            archive.extractall(directory)
    except zipfile.BadZipFile as error:
        raise FmuFileError(f"{path}: this is no FMU ({error}); an FMU is a zip archive") from error
