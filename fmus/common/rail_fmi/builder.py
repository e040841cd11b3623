"""Building an FMU from an entry script and the packages it needs."""

import ast
import datetime
import hashlib
import importlib.metadata
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from rail_fmi import bundle
from rail_fmi.errors import BuildError
from rail_fmi.identity import MANIFEST

REQUIREMENTS = ("numpy>=2.0", "scipy>=1.15")

_ZIP_TIME = (1980, 1, 1, 0, 0, 0)
_PREAMBLE = """\
# Put here by rail_fmi.builder: load the packages this FMU carries (see {module}.py).
from {module} import prepare as _prepare

_prepare(globals(), {packages})

"""


def build_fmu(
    entry_script: str | Path,
    packages: Iterable[str],
    out_dir: str | Path,
    *,
    requirements: Iterable[str] = REQUIREMENTS,
) -> Path:
    """Build an FMU; the same sources give the same bytes.

    Parameters
    ----------
    entry_script
        Python file that defines the slave: a subclass of
        :class:`rail_fmi.RailSlave` with the longest ancestry in the file.
    packages
        Names of the importable packages that the FMU carries, ``rail_fmi`` and
        ``rail_quantities`` among them.
    out_dir
        Folder of the FMU, which is named by the slave's ``MODEL_NAME``.
    requirements
        Libraries that must be installed where the FMU runs.

    Returns
    -------
    pathlib.Path
        The FMU.

    Raises
    ------
    BuildError
        If a package is not found or the slave cannot be described; the
        message has the reason.

    Notes
    -----
    Model description, presets and documents come from the packed copy, in a
    process of its own, so the caller's modules and paths stay as they are.
    ``generationDateAndTime`` is the date of the sources: ``SOURCE_DATE_EPOCH``
    if set, else that of the last commit that touched them, else that of the
    newest file.
    """
    script = Path(entry_script)
    folders = {name: _package_folder(name) for name in sorted(set(packages))}
    hashes = {name: bundle.source_hash(folder) for name, folder in folders.items()}
    requirements = tuple(requirements)
    out = Path(out_dir)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="rail_fmi_") as workshop:
        stage = Path(workshop, "stage")
        entry = _fill_stage(stage, script, folders, hashes, requirements)
        _add_licenses(Path(workshop, "documentation", "licenses"))
        raw = _run_worker(stage, entry, Path(workshop))
        fmu = out / raw.name
        _write_reproducible(raw, fmu)
    return fmu


def _package_folder(name: str) -> Path:
    spec = importlib.util.find_spec(name)
    places = list(spec.submodule_search_locations or []) if spec else []
    if len(places) != 1 or not Path(places[0], "__init__.py").is_file():
        raise BuildError(
            f"package {name!r} is not an importable package; install the project or set PYTHONPATH"
        )
    return Path(places[0])


def _fill_stage(
    stage: Path,
    script: Path,
    folders: Mapping[str, Path],
    hashes: Mapping[str, str],
    requirements: tuple[str, ...],
) -> Path:
    """Write what goes into ``resources`` and return the entry script there.

    Entry script and loader get names with the hash of all sources: in one
    process the first module of a name wins, silently.
    """
    loader = Path(bundle.__file__).read_text(encoding="utf-8")
    code = script.read_text(encoding="utf-8")
    identity = json.dumps([code, loader, hashes, requirements])
    sources = hashlib.sha256(identity.encode()).hexdigest()
    stage.mkdir()
    for name, folder in folders.items():
        for path in bundle.source_files(folder):
            target = stage / name / path.relative_to(folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
    module = f"rail_bundle_{sources[:12]}"
    (stage / f"{module}.py").write_text(loader, encoding="utf-8")
    (stage / "requirements.txt").write_text("\n".join(requirements) + "\n", encoding="utf-8")
    tool = f"rail_fmi with pythonfmu {importlib.metadata.version('pythonfmu')}"
    date = _source_date([script, *folders.values()])
    manifest = {"sources": sources, "packages": dict(hashes), "date": date, "tool": tool}
    (stage / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    entry = stage / f"{script.stem}_{sources[:12]}.py"
    preamble = _PREAMBLE.format(module=module, packages=json.dumps(dict(hashes), indent=4))
    entry.write_text(_with_preamble(code, preamble), encoding="utf-8")
    return entry


def _add_licenses(folder: Path) -> None:
    """Write the licences of this project and of pythonfmu, whose binary is in the FMU."""
    folder.mkdir(parents=True)
    for name, distribution in (("license.txt", "rail-cosim"), ("pythonfmu.txt", "pythonfmu")):
        if found := _license_of(distribution):
            shutil.copyfile(found, folder / name)


def _license_of(distribution: str) -> Path | None:
    try:
        files = importlib.metadata.files(distribution) or []
    except importlib.metadata.PackageNotFoundError:
        files = []
    places = [Path(str(file.locate())) for file in files if file.name == "LICENSE"]
    if distribution == "rail-cosim":  # a source tree that was installed before it had one
        places.append(Path(__file__).resolve().parents[3] / "LICENSE")
    return next((place for place in places if place.is_file()), None)


def _with_preamble(code: str, preamble: str) -> str:
    """Return the code with the preamble after its docstring and ``__future__`` imports."""
    lines, after = code.splitlines(keepends=True), 0
    for statement in ast.parse(code).body:
        is_text = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
        is_future = isinstance(statement, ast.ImportFrom) and statement.module == "__future__"
        if not (is_text or is_future):
            break
        after = statement.end_lineno or 0
    return "".join(lines[:after]) + "\n" + preamble + "".join(lines[after:])


def _source_date(paths: list[Path]) -> str:
    """Return the date of the sources, in the form that the FMI schema wants."""
    chosen = os.environ.get("SOURCE_DATE_EPOCH") or _commit_time(paths)
    if chosen:
        seconds = int(chosen)
    else:
        files = [
            file
            for path in paths
            for file in (bundle.source_files(path) if path.is_dir() else [path])
        ]
        seconds = int(max(file.stat().st_mtime for file in files))
    moment = datetime.datetime.fromtimestamp(seconds, datetime.UTC)
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def _commit_time(paths: list[Path]) -> str:
    """Return the time of the last commit that touched the paths, empty if git knows none."""
    command = ["git", "log", "-1", "--format=%ct", "--", *(str(path.resolve()) for path in paths)]
    try:
        done = subprocess.run(
            command, cwd=paths[0].resolve().parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""  # no git, or not in a repository
    return done.stdout.strip()


def _run_worker(stage: Path, entry: Path, workshop: Path) -> Path:
    """Describe and pack in another process; return the FMU that pythonfmu wrote."""
    out = workshop / "out"
    out.mkdir()
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        "PYTHONDONTWRITEBYTECODE": "1",
        bundle.CACHE_VARIABLE: str(workshop / "cache"),
    }
    worker = Path(__file__).with_name("build_worker.py")
    done = subprocess.run(
        [sys.executable, "-P", str(worker), str(stage), entry.stem, str(out)],
        env=environment,
        capture_output=True,
        text=True,
    )
    found = sorted(out.glob("*.fmu"))
    if done.returncode != 0 or len(found) != 1:
        raise BuildError(f"the FMU of {entry.stem} could not be built:\n{done.stderr.strip()}")
    return found[0]


def _write_reproducible(raw: Path, fmu: Path) -> None:
    """Copy a zip file with sorted entries, fixed times and rights, in one rename."""
    part = fmu.with_name(f".{fmu.name}.{os.getpid()}")
    with zipfile.ZipFile(raw) as source, zipfile.ZipFile(part, "w") as target:
        for name in sorted(source.namelist()):
            entry = zipfile.ZipInfo(name, _ZIP_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, so that the rights count
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            target.writestr(entry, source.read(name))
    part.replace(fmu)
