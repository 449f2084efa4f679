"""Files that a scene reads: those named by its fields for files."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from semiwear.scene.scene import Scene
from semiwear.scene.schema import schema_of_data
from semiwear.scene.toml_io import flat
from semiwear.untyped import Value


def named_files(data: Mapping[str, Value]) -> dict[str, str]:
    """Paths of the files that nested tables of a scene name, under the dotted keys of their fields."""
    rules = schema_of_data(data).rules
    return {
        key: value
        for key, value in flat(data)
        if isinstance(value, str) and key in rules and rules[key].names_file(value)
    }


def scene_files(scene: Scene) -> dict[str, str]:
    """Paths of the files that a scene reads, under the dotted keys of its fields."""
    return named_files(scene.to_dict())


def file_digests(data: Mapping[str, Value]) -> dict[str, str]:
    """SHA-256 of every file that nested tables of a scene name, by path; a message if there is no plain file."""
    return {path: _digest(Path(path)) for path in named_files(data).values()}


def _digest(path: Path) -> str:
    try:
        if not path.is_file():
            return "no plain file"
        with path.open("rb") as opened:
            return hashlib.file_digest(opened, "sha256").hexdigest()
    except (OSError, ValueError) as error:
        return f"cannot be read ({error})"
