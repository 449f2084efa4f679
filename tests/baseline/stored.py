"""Where digests are kept: one file a run."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

__all__ = ["read", "write"]

_DATA = Path(__file__).parent / "data"


def _path(name: str) -> Path:
    return _DATA / (re.sub(r"\W+", "_", name) + ".json")


def read(name: str) -> dict[str, dict[str, Any]]:
    """The stored digest of a run."""
    stored: dict[str, dict[str, Any]] = json.loads(_path(name).read_text(encoding="utf-8"))
    return stored


def write(name: str, digest: dict[str, dict[str, Any]]) -> Path:
    """Keep the digest of a run, a variable a line; returns the file."""
    lines = [f"{json.dumps(key)}: {json.dumps(digest[key])}" for key in sorted(digest)]
    path = _path(name)
    path.parent.mkdir(exist_ok=True)
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    return path
