"""The part of a build that runs in a process of its own: describe the slave and pack it."""

import sys
from pathlib import Path
from typing import Any

from pythonfmu.builder import FmuBuilder, get_model_class


def main(stage: Path, entry: str, out: Path) -> None:
    """Add presets and documents to the stage, and let pythonfmu write the FMU.

    Parameters
    ----------
    stage
        Folder with all that goes into ``resources``.
    entry
        Module name of the entry script in it.
    out
        Folder for the FMU; beside it is ``documentation``, to which documents are added.
    """
    sys.path.insert(0, str(stage))
    script = stage / f"{entry}.py"
    model: Any = get_model_class(script)  # loads the packages of the stage

    from rail_fmi import bundle
    from rail_fmi.documentation import documentation_page, documentation_table, general_guide
    from rail_fmi.presets import parameter_file

    slave = model(instance_name="build", resources=str(stage))
    about = slave.to_xml().get("description", "")
    if model.PRESETS:
        (stage / "presets").mkdir()
    for name, values in model.PRESETS.items():
        contents = parameter_file(name, values, slave.table)
        (stage / "presets" / f"{name}.ssv").write_bytes(contents)
    documents = out.parent / "documentation"
    python = ".".join(map(str, bundle.PYTHON))
    requirements = (stage / "requirements.txt").read_text(encoding="utf-8").split()
    guide = {**model.GUIDE, **general_guide(python, requirements)}
    page = documentation_page(slave.modelName, about, guide, slave.table.values())
    (documents / "index.html").write_text(page, encoding="utf-8")
    table = documentation_table(slave.table.values())
    (documents / "variables.md").write_text(table, encoding="utf-8")
    FmuBuilder.build_FMU(
        script,
        dest=out,
        project_files=[path for path in stage.iterdir() if path != script],
        documentation_folder=documents,
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
