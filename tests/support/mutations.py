"""Deliberate faults in the sources: one line each, and the tests that must notice it."""

import dataclasses
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIST = ROOT / "tests" / "mutations" / "faults.toml"


class StaleFaultError(Exception):
    """An entry of the list that no longer fits the sources."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fault:
    """One deliberate fault.

    Attributes
    ----------
    number
        Its place in the list, from 1.
    file
        Source file from the repository's root.
    before, after
        The line as it is, without indentation, and as the fault makes it.
    breaks
        What is wrong then, in a few words.
    tests
        Test files (or ``file::test``) of the quick suite; at least one must fail.
    """

    number: int
    file: str
    before: str
    after: str
    breaks: str
    tests: tuple[str, ...]

    def line(self, root: Path) -> int:
        """Return the number of its line, from 0, in the sources below ``root``.

        Raises
        ------
        StaleFaultError
            If the line is not there exactly once, or the fault changes nothing.
        """
        where = f"fault {self.number} in {self.file}"
        if not (root / self.file).is_file():
            raise StaleFaultError(f"{where}: there is no such file")
        found = self._lines((root / self.file).read_text(encoding="utf-8"))
        if len(found) != 1:
            raise StaleFaultError(f"{where}: the line is there {len(found)} times: {self.before}")
        if self.after == self.before or "\n" in self.after:
            raise StaleFaultError(f"{where}: it must change the line, and no more than that")
        return found[0]

    def line_in(self, text: str) -> int:
        """Return the number of its line, from 0, in the text of its file."""
        return self._lines(text)[0]

    def _lines(self, text: str) -> list[int]:
        return [i for i, line in enumerate(text.splitlines()) if line.strip() == self.before]

    def check_tests(self, root: Path) -> None:
        """Raise :class:`StaleFaultError` if a test that it names does not exist."""
        for test in self.tests:
            file, _, name = test.partition("::")
            path = root / file
            if not path.is_file() or (name and f"def {name}(" not in path.read_text("utf-8")):
                raise StaleFaultError(f"fault {self.number}: there is no test {test}")

    def apply(self, root: Path) -> str:
        """Write the fault into the sources below ``root``; return the text there was."""
        at, path = self.line(root), root / self.file
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines(keepends=True)
        lines[at] = lines[at].replace(self.before, self.after)
        path.write_text("".join(lines), encoding="utf-8")
        return text


def faults(path: Path = LIST) -> list[Fault]:
    """Return all faults of the list."""
    entries = tomllib.loads(path.read_text(encoding="utf-8"))["fault"]
    return [
        Fault(number=number, **{**entry, "tests": tuple(entry["tests"])})
        for number, entry in enumerate(entries, start=1)
    ]
