"""Who an FMU is: hash of its sources and table, GUID, date."""

import dataclasses
import hashlib
import json
from pathlib import Path

MANIFEST = "bundle.json"
_EPOCH = "1980-01-01T00:00:00Z"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Identity:
    """Identity of an FMU.

    Attributes
    ----------
    model_hash
        SHA-256 of model name, sources and table of variables, hexadecimal.
    guid
        The same hash in the form of a GUID, so equal sources give equal FMUs.
    date, tool
        Date of the sources in UTC, and what made the FMU.
    """

    model_hash: str
    guid: str
    date: str
    tool: str


def read_identity(resources: str | None, model_name: str | None, table_digest: str) -> Identity:
    """Return the identity from the manifest that the builder left in ``resources``.

    A slave that is used without an FMU has no manifest; its hash is that of its
    table alone.
    """
    sources, date, tool = "", _EPOCH, "rail_fmi"
    path = Path(resources or "") / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        sources, date, tool = (str(manifest[key]) for key in ("sources", "date", "tool"))
    except (OSError, ValueError, KeyError):
        pass  # not in an FMU
    text = "\n".join([model_name or "", sources, table_digest])
    digest = hashlib.sha256(text.encode()).hexdigest()
    parts = (digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])
    return Identity(model_hash=digest, guid="{" + "-".join(parts) + "}", date=date, tool=tool)
