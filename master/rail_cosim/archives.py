"""Zip archives and XML from elsewhere (FMU, SSP): read them without trusting them.

No member leads out of the folder it is extracted to, none is a link, encrypted, there twice, or
larger than it says; XML has no document type, hence no entities to expand or to fetch.
"""

from __future__ import annotations

import contextlib
import stat
import xml.etree.ElementTree as ElementTree
import xml.parsers.expat as expat
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath

from rail_cosim.errors import FmuFileError

MOST_MEMBERS = 20_000
LARGEST = 4 * 2**30
"""Most bytes that all members of an archive may have together, unpacked."""
LARGEST_XML = 64 * 2**20
"""Most bytes of a description or a parameter set."""
_CHUNK = 2**20


@contextlib.contextmanager
def opened(path: Path, what: str = "FMU") -> Iterator[zipfile.ZipFile]:
    """Open an archive whose list of members is harmless.

    Parameters
    ----------
    path
        The file.
    what
        What it should be, for messages.

    Raises
    ------
    FmuFileError
        If there is no such file, or it is no archive, or one that must not be unpacked; also
        for damage that is found while it is read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            _check_members(path, archive.infolist())
            yield archive
    except FileNotFoundError as error:
        raise FmuFileError(f"{path}: there is no such file") from error
    except IsADirectoryError as error:
        raise FmuFileError(f"{path}: this is a directory, not an {what}") from error
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, ValueError) as error:
        raise FmuFileError(
            f"{path}: this is no {what}, or a damaged one ({error}); it must be a zip archive"
        ) from error
    except OSError as error:
        raise FmuFileError(f"{path}: it cannot be read ({error.strerror or error})") from error


def _check_members(path: Path, members: list[zipfile.ZipInfo]) -> None:
    def refused(why: str) -> FmuFileError:
        return FmuFileError(f"{path}: {why}; it is not unpacked")

    if len(members) > MOST_MEMBERS:
        raise refused(f"the archive has {len(members)} members, more than {MOST_MEMBERS}")
    total = sum(member.file_size for member in members)
    if total > LARGEST:
        raise refused(f"unpacked it would be {total / 2**30:.3g} GiB, more than {LARGEST >> 30}")
    seen: set[str] = set()
    for member in members:
        name = member.filename
        if not is_inside(name):
            raise refused(f"the member {name!r} points out of the archive")
        if stat.S_ISLNK(member.external_attr >> 16):
            raise refused(f"the member {name!r} is a link")
        if member.flag_bits & 1:
            raise refused(f"the member {name!r} is encrypted")
        folded = name.rstrip("/").casefold()
        if folded in seen:
            raise refused(f"the member {name!r} is there twice")
        seen.add(folded)


def is_inside(name: str) -> bool:
    """Whether a member's name stays below the folder it is extracted to, on any system."""
    parts = PureWindowsPath(name)  # knows both kinds of slashes, and drives
    plain = bool(name) and not parts.drive and not parts.root and ":" not in name
    return plain and ".." not in parts.parts and "\\" not in name and "\0" not in name


def read_member(archive: zipfile.ZipFile, name: str, most: int = LARGEST_XML) -> bytes:
    """Return a member's content.

    Raises
    ------
    KeyError
        If there is none.
    FmuFileError
        If it is larger than ``most`` bytes.
    """
    with archive.open(name) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise FmuFileError(
            f"{archive.filename}: {name} is larger than {most >> 20} MiB; it is not read"
        )
    return content


def unpack(archive: zipfile.ZipFile, folder: Path) -> None:
    """Extract all members of an archive that was :func:`opened`.

    Raises
    ------
    FmuFileError
        If a member is larger than the archive's list says.
    """
    for member in archive.infolist():
        target = folder / member.filename
        if member.is_dir():
            target.mkdir(parents=True, exist_ok=True)
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        left = member.file_size
        with archive.open(member) as source, target.open("xb") as file:
            while chunk := source.read(_CHUNK):
                left -= len(chunk)
                if left < 0:
                    raise FmuFileError(
                        f"{archive.filename}: {member.filename!r} is larger than the archive says"
                    )
                file.write(chunk)


def is_whole(archive: zipfile.ZipFile, folder: Path) -> bool:
    """Whether a folder has all members of an archive with the right contents (CRC-32)."""
    try:
        return all(
            zlib.crc32((folder / member.filename).read_bytes()) == member.CRC
            for member in archive.infolist()
            if not member.is_dir()
        )
    except OSError:
        return False


def parse_xml(content: bytes) -> ElementTree.Element:
    """Return the root of an XML document without document type.

    Raises
    ------
    xml.etree.ElementTree.ParseError
        If it is not well formed, or declares a document type: entities, which can grow without
        limit or name other files, can come in no other way.
    """
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refuse_doctype
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise ElementTree.ParseError(str(error)) from error
    return ElementTree.fromstring(content)


def _refuse_doctype(name: str, *_: object) -> None:
    raise ElementTree.ParseError(f"it declares the document type {name!r}, which is not accepted")
