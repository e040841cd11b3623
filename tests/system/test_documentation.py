"""The documentation: its commands parse, its Python compiles, its pages are all there and build."""

import importlib.util
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from product import PATIENCE
from rail_cosim.cli import app
from rail_cosim.description import read_description
from typer.main import get_command

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "examples").rglob("*.md")),
    *sorted((ROOT / "fmus").rglob("README.md")),
]
MADE = {  # by docs/_hooks/pages.py
    "models/vehicle.md": "fmus/vehicle/README.md",
    "models/track.md": "fmus/track/README.md",
    "models/fmi.md": "fmus/common/README.md",
    "models/vehicle_variables.md": None,
    "models/track_variables.md": None,
    "examples.md": "examples/README.md",
    "changes.md": "CHANGELOG.md",
    "contributing.md": "CONTRIBUTING.md",
    "command_line.md": None,
}
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page, *languages):
    return [text for word, text in _BLOCK.findall(page.read_text("utf-8")) if word in languages]


def commands(page):
    """Return the words of each line that starts our command."""
    lines = "\n".join(blocks(page, "", "text", "sh", "bash")).replace("\\\n", " ").splitlines()
    found = (shlex.split(line, comments=True) for line in lines if line.startswith("rail-cosim "))
    return [words[1:] for words in found]


COMMANDS = [(page, words) for page in PAGES for words in commands(page)]


def test_there_are_commands_to_look_at():
    assert len(COMMANDS) > 40


@pytest.mark.parametrize(
    ("page", "words"), COMMANDS, ids=[f"{p.stem}-{'_'.join(w)[:60]}" for p, w in COMMANDS]
)
def test_a_command_in_the_documentation_parses(page, words):
    """Its options exist and take such values; nothing is run."""
    group = get_command(app)
    name, *rest = words
    if name.startswith("--"):
        assert name in {option for p in group.params for option in p.opts}
        return
    command = group.commands[name]
    command.make_context(name, rest, resilient_parsing=False)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_python_and_toml_in_the_documentation_compile(page):
    for text in blocks(page, "python"):
        compile(text, str(page), "exec")
    for text in blocks(page, "toml"):
        tomllib.loads(text)


def nav(entries):
    for entry in entries:
        for value in entry.values():
            yield from nav(value) if isinstance(value, list) else [value]


def test_the_pages_of_the_menu_are_all_pages():
    config = yaml.safe_load((ROOT / "mkdocs.yml").read_text("utf-8"))
    listed = list(nav(config["nav"]))
    written = {p.relative_to(ROOT / "docs").as_posix() for p in (ROOT / "docs").rglob("*.md")}
    assert len(set(listed)) == len(listed)
    assert set(listed) == written | set(MADE)
    for source in filter(None, MADE.values()):
        assert (ROOT / source).is_file()


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_between_files_of_the_sources_lead_somewhere(page):
    for target in re.findall(r"\]\((?!https?:)([^)#\s]+)[)#]", page.read_text("utf-8")):
        known = (page.parent / target).exists()
        inside = page.is_relative_to(ROOT / "docs")
        made = inside and _from_docs(page, target) in MADE
        assert known or made, f"{page}: {target}"


def _from_docs(page, target):
    path = Path(os.path.normpath(page.parent / target))
    return path.relative_to(ROOT / "docs").as_posix() if path.is_relative_to(ROOT / "docs") else ""


def pages():
    """Return the module that makes pages."""
    spec = importlib.util.spec_from_file_location("pages", ROOT / "docs/_hooks/pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif(not importlib.util.find_spec("mkdocs"), reason="needs the extra docs")
@pytest.mark.parametrize("role", ["vehicle", "track"])
def test_each_variable_stands_in_the_table_in_its_own_words(fmus, role):
    variables = list(read_description(getattr(fmus, role)).variables.values())
    lines = pages()._table(variables).splitlines()[2:]
    rows = [re.split(r"(?<!\\)\|", line.replace("\\|", "\0")) for line in lines]
    table = {}
    for _, name, *_, meaning, _ in rows:
        table.setdefault(re.search("`(.+?)`", name)[1].replace("\0", "|"), set()).add(
            meaning.strip().replace("\0", "|")
        )
    for variable in variables:
        name = re.sub(r"\b(left|right)\b", "left/right", re.sub(r"\[\d+\]", "[i]", variable.name))
        assert table[name] == {variable.description}
    assert not any("left/right" in meaning for meanings in table.values() for meaning in meanings)


@pytest.mark.parametrize(
    ("role", "name", "word"),
    [
        ("vehicle", "wheelset[2].lateral_displacement", "to the right"),
        ("track", "wheelset[2].lateral_displacement", "to the right"),
        ("track", "wheelset[1].contact.vertical_force", "downwards: minus the axle load at rest"),
        ("track", "wheelset[3].left.rail_roll_angle", "positive with its head to the right"),
        ("track", "wheelset[3].left.contact_angle", "positive where it falls to the right"),
        ("vehicle", "car_body.pitch_angle", "positive with the front up"),
        ("vehicle", "yaw_damper[1].left.force", "on the car body, positive rearwards"),
    ],
)
def test_a_description_gives_the_sign(fmus, role, name, word):
    assert word in read_description(getattr(fmus, role)).variables[name].description


def installed(*modules):
    return all(importlib.util.find_spec(name) for name in modules)


@pytest.mark.skipif(
    not installed("mkdocs", "mkdocstrings", "material", "latex2mathml"),
    reason="needs the extra docs",
)
def test_the_site_builds_without_a_warning_and_loads_nothing_from_elsewhere(fmus, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", tmp_path / "site"],
        cwd=ROOT,
        env=fmus.environment() | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    loads = re.compile(r'<(?:script|link|img|iframe)\b[^>]*?(?:src|href)="?(https?:[^"> ]*)')
    site = tmp_path / "site"
    pages = sorted(site.rglob("*.html"))
    text = {page.relative_to(site).as_posix(): page.read_text("utf-8") for page in pages}
    foreign = [(name, url) for name, page in text.items() for url in loads.findall(page)]
    assert foreign == []
    # Made from the FMUs: units, limits, meaning.
    row = re.search(
        r"fastener\.vertical_stiffness</code>.*?</tr>", text["models/track_variables.html"], re.S
    )
    assert re.sub(r"<[^>]+>|\s+", " ", row[0]).split()[1:5] == ["real", "N/m", "40000000", "≥"]
    assert 'class="arithmatex"' not in text["postprocessing.html"]
    assert "<math" in text["postprocessing.html"]
    assert "rail-cosim sweep sweep.toml" in text["command_line.html"]
    # Sphinx's marks do not show.
    assert [
        name for name, page in text.items() if re.search(r":(class|func|mod|math):", page)
    ] == []
