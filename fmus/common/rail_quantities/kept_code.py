"""Compiled code that numba keeps on disk, with a checksum: what was damaged is compiled anew.

numba's files are pickles with nothing to tell damage by: one that was cut short ends in an error
at set-up, and a changed byte can go unnoticed. Two processes that compile different signatures of
a function at the same time may also leave the code of one under the name of the other.
"""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# (numba has no types.)

import contextlib
import hashlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from numba.core.caching import IndexDataCacheFile

_DIGEST_SIZE = 32


class CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]
    """The files of one function: behind each its SHA-256, and with each code what it is for.

    A pickle ends by itself, so numba reads such a file as any other. Files without a checksum
    count as damaged; so does code that is not for what it was looked up for.
    """

    def save(self, key: Any, data: Any) -> None:
        """Keep compiled code; if there is no room, it costs time only."""
        with contextlib.suppress(OSError):
            super().save(key, (key, data))

    def load(self, key: Any) -> Any:
        """Return what was kept for ``key``, ``None`` if there is nothing or it is damaged."""
        found = super().load(key)
        return None if found is None or found[0] != key else found[1]

    def _load_index(self) -> dict[Any, str]:
        if not _is_whole(self._index_path):
            return {}
        try:
            return super()._load_index()
        except Exception:  # it names types that this version of the program does not have
            return {}

    def _load_data(self, name: str) -> Any:
        path = self._data_path(name)
        if not _is_whole(path):
            raise FileNotFoundError(path)  # numba compiles anew, and writes the file again
        return super()._load_data(name)

    @contextlib.contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[IO[bytes]]:
        content = io.BytesIO()
        yield content
        with super()._open_for_write(filepath) as file:
            file.write(content.getvalue() + hashlib.sha256(content.getvalue()).digest())


def _is_whole(path: str) -> bool:
    try:
        content = Path(path).read_bytes()
    except OSError:
        return False
    return hashlib.sha256(content[:-_DIGEST_SIZE]).digest() == content[-_DIGEST_SIZE:]


def with_checksums(function: Any) -> Any:
    """Have a function that numba compiles keep its code with checksums.

    Parameters
    ----------
    function
        What ``numba.njit(cache=True)`` returns. Returned as it is where numba keeps nothing.
    """
    cache: Any = getattr(function, "_cache", None)
    if isinstance(getattr(cache, "_cache_file", None), IndexDataCacheFile):
        cache._cache_file = CheckedFiles(
            cache_path=cache.cache_path,
            filename_base=cache._impl.filename_base,
            source_stamp=cache._impl.locator.get_source_stamp(),
        )
    return function
