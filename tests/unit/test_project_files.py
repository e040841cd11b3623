"""Files about the project say the same as its metadata."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_licence_is_the_declared_one_and_is_packed():
    (name,) = PROJECT["license-files"]
    assert PROJECT["license"] == "BSD-3-Clause"
    assert (ROOT / name).read_text(encoding="utf-8").startswith("BSD 3-Clause License\n")


def test_citation_has_the_version_the_licence_and_the_article():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    given = dict(re.findall(r"^ *([\w-]+): (\S+)$", text, re.MULTILINE))
    assert given["version"] == PROJECT["version"]
    assert given["license"] == PROJECT["license"]
    assert given["doi"] == "10.1155/2020/6878252"
