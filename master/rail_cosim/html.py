"""What the pages have in common: their style, and the line that says what made them."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import metadata

from rail_cosim import version

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #fff; max-width: 75em;
  margin: 2em auto; padding: 0 1em; }
h1, h2, h3 { font-weight: 600; } h2 { margin-top: 2em; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th, td { padding: .25em .6em; border-bottom: 1px solid #ddd; vertical-align: top;
  text-align: left; }
td.number, th.number { text-align: right; white-space: nowrap;
  font-variant-numeric: tabular-nums; }
figcaption { font-weight: 600; margin-bottom: .4em; }
footer { margin-top: 3em; color: #666; font-size: 13px; }
"""


def made(command: str, libraries: Sequence[str]) -> str:
    """Return command, versions, machine and date in one line, not escaped."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in libraries)
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return (
        f"{command}; rail-cosim {version()}, Python {platform.python_version()} on "
        f"{platform.system()} {platform.machine()}, {versions}; {now}"
    )
