"""Pages that are made from the product itself: variables, command line, examples, READMEs."""

import os
import posixpath
import re
import sys
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[2]
for folder in ("master", "fmus/common", "fmus/track", "fmus/vehicle"):
    sys.path.insert(0, str(ROOT / folder))

READMES = {
    "fmus/vehicle/README.md": "models/vehicle.md",
    "fmus/track/README.md": "models/track.md",
    "fmus/common/README.md": "models/fmi.md",
    "CHANGELOG.md": "changes.md",
    "CONTRIBUTING.md": "contributing.md",
    "examples/README.md": "examples.md",
}
"""Files outside of docs/ that are pages, too."""
SUBPAGES = ("single_wheelset", "track_alone", "vehicle_alone")

_LINK = re.compile(r"(?<=\]\()(?!https?:|#|mailto:)([^)#\s]+)(?=[)#])")
_INDEX = re.compile(r"\[(\d+)\]")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    made = {
        target: (ROOT / source).read_text(encoding="utf-8") for source, target in READMES.items()
    }
    made["examples.md"] = _examples(made["examples.md"])
    made["command_line.md"] = _command_line()
    made |= {f"models/{role}_variables.md": _variables(role) for role in ("vehicle", "track")}
    for path, content in made.items():
        files.append(File.generated(config, path, content=content))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Point links between files of the sources to the pages made of them."""
    uri = page.file.src_uri
    source = next((file for file, target in READMES.items() if target == uri), f"docs/{uri}")

    def moved(match: re.Match[str]) -> str:
        wanted = posixpath.normpath(posixpath.join(posixpath.dirname(source), match[1]))
        target = READMES.get(wanted) or _in_examples(wanted)
        if target is None and wanted.startswith("docs/"):
            target = wanted.removeprefix("docs/")
        if target is None:
            return match[1]
        return os.path.relpath(target, posixpath.dirname(uri) or ".").replace(os.sep, "/")

    return _LINK.sub(moved, markdown)


def _in_examples(path: str) -> str | None:
    parts = path.split("/")
    if parts[0] != "examples" or len(parts) < 2:
        return None
    place = parts[1] if parts[1] in SUBPAGES else parts[1].replace(".", "")
    return f"examples.md#{place}"


def _examples(readme: str) -> str:
    """Return the list of examples, and below it the examples themselves."""
    listed = re.sub(
        r"\[`([\w.]+)`\]\([^)]*\)", lambda m: f"[`{m[1]}`](#{m[1].replace('.', '')})", readme
    )
    parts = [
        listed.replace("# Examples", "# Examples\n\nIn the folder `examples` of the sources.", 1)
    ]
    for script in sorted((ROOT / "examples").glob("*.py")):
        code = script.read_text(encoding="utf-8").rstrip()
        parts.append(
            f"## {script.name} {{ #{script.name.replace('.', '')} }}\n\n```python\n{code}\n```"
        )
    for name in SUBPAGES:
        text = (ROOT / "examples" / name / "README.md").read_text(encoding="utf-8")
        title, _, rest = text.partition("\n")
        parts.append(f"## {title.lstrip('# ')} {{ #{name} }}\n{rest}")
    return "\n\n".join(parts)


def _command_line() -> str:
    """Return the help texts of all commands."""
    from rail_cosim.cli import app
    from typer.main import get_command
    from typer.testing import CliRunner

    names = [None, *get_command(app).commands]  # type: ignore[attr-defined]
    parts = ["# Command line\n\nWhat `rail-cosim --help` says, and that of each command."]
    for name in names:
        arguments = [name, "--help"] if name else ["--help"]
        done = CliRunner().invoke(app, arguments, prog_name="rail-cosim", env={"COLUMNS": "100"})
        title = f"rail-cosim {name}" if name else "rail-cosim"
        parts.append(f"## {title}\n\n```text\n{done.stdout.rstrip()}\n```")
    return "\n\n".join(parts)


def _variables(role: str) -> str:
    """Return the tables of an FMU's variables, as its modelDescription.xml has them."""
    from rail_cosim.builder import RECIPES, built_fmu
    from rail_cosim.description import read_description

    about = read_description(built_fmu(RECIPES[role]))
    variables = list(about.variables.values())
    parts = [
        f"---\nhide: [toc]\n---\n# {about.model_name}: variables",
        f"All {len(variables)} variables of the FMU, as declared in its `modelDescription.xml`. "
        "`[i]` stands for the numbers that are given, `left/right` for both sides.",
    ]
    for title, causalities in (
        ("Parameters", ("parameter",)),
        ("Inputs", ("input",)),
        ("Outputs", ("output",)),
        ("Calculated parameters", ("calculatedParameter",)),
        ("Local variables", ("local",)),
    ):
        chosen = [variable for variable in variables if variable.causality in causalities]
        if chosen:
            parts.append(f"## {title}\n\n{_table(chosen)}")
    return "\n\n".join(parts)


def _table(variables: list) -> str:
    """Return a table with one row for all variables whose names differ in numbers and side only.

    A row shows what the FMU says: variables that are described in other words are other rows.
    """
    rows: dict[tuple, list] = {}
    for variable in variables:
        name = re.sub(r"\b(left|right)\b", "left/right", _INDEX.sub("[i]", variable.name))
        tunable = " (tunable)" if variable.variability == "tunable" else ""
        limits = ", ".join(
            f"{sign} {value:g}"
            for sign, value in (("≥", variable.minimum), ("≤", variable.maximum))
            if value is not None
        )
        start = "" if variable.start is None else str(variable.start)
        if isinstance(variable.start, float):
            start = f"{variable.start:.10g}"
        unit = "" if variable.unit in ("", "1") else variable.unit
        key = (name, variable.kind + tunable, unit, start, limits, variable.description)
        rows.setdefault(key, []).append(variable)
    lines = ["| name | type | unit | start | limits | meaning |", "|---|---|---|---|---|---|"]
    for (name, kind, unit, start, limits, meaning), members in rows.items():
        shown = f"`{name}`{_numbers([member.name for member in members])}"
        cells = (shown, kind, unit, f"`{start}`" if start else "", limits, meaning)
        lines.append(
            "| " + " | ".join(c.replace("|", "\\|").replace("\n", " ") for c in cells) + " |"
        )
    return "\n".join(lines)


def _numbers(names: list[str]) -> str:
    """Return which numbers stand for ``[i]``: ", i = 1 to 4"."""
    found = [int(number) for name in names for number in _INDEX.findall(name)]
    if not found or min(found) == max(found):
        return f", i = {found[0]}" if found else ""
    return f", i = {min(found)} to {max(found)}"
