"""Where digests are kept: one file a run, with the processor on which it was computed."""

import json
import re
from pathlib import Path
from typing import Any

import llvmlite.binding

from tests.baseline.digest import ELSEWHERE, TOLERANCE

_PROCESSOR = "processor"
_DATA = Path(__file__).parent / "data"


def _path(name: str) -> Path:
    return _DATA / (re.sub(r"\W+", "_", name) + ".json")


def read(name: str) -> dict[str, dict[str, Any]]:
    """The stored digest of a run."""
    stored = _content(name)
    stored.pop(_PROCESSOR, None)
    return stored


def tolerance(name: str) -> float:
    """Closeness of a run's results to the stored ones: on another processor sums are taken in another order."""
    return TOLERANCE if _content(name).get(_PROCESSOR) == llvmlite.binding.get_host_cpu_name() else ELSEWHERE


def _content(name: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(_path(name).read_text(encoding="utf-8"))
    return content


def write(name: str, digest: dict[str, dict[str, Any]]) -> Path:
    """Keep the digest of a run, a variable a line; returns the file."""
    told: dict[str, Any] = {_PROCESSOR: llvmlite.binding.get_host_cpu_name(), **digest}
    lines = [f"{json.dumps(key)}: {json.dumps(told[key])}" for key in sorted(told)]
    path = _path(name)
    path.parent.mkdir(exist_ok=True)
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    return path
