"""Scenes by name, from files and from text."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import BinaryIO

from semiwear.errors import Problem, SceneError
from semiwear.scene.closest import advised_name
from semiwear.scene.scene import Check, Scene, scene_from_dict
from semiwear.scene.toml_io import read_toml
from semiwear.sources import NETCDF, no_pipe
from semiwear.untyped import Value

_SUFFIX = ".toml"
_MOST_BYTES = 1_000_000
_SEAL = b"semiwear sha256:"  # near the end of results, see `semiwear.results.files`
_SHIPPED = resources.files("semiwear.scene") / "scenes"


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with semiwear, sorted.

    Examples
    --------
    >>> import semiwear as sw
    >>> "spur_fzg_c" in sw.shipped_scenes()
    True
    """
    names = (entry.name for entry in _SHIPPED.iterdir())
    return sorted(name.removesuffix(_SUFFIX) for name in names if name.endswith(_SUFFIX))


def load_scene(
    name_or_path: str | os.PathLike[str], *, check: Check | None = None, changes: Mapping[str, Value] | None = None
) -> Scene:
    """Load a scene that comes with semiwear, or a scene file.

    Parameters
    ----------
    name_or_path : str or path
        A name from `shipped_scenes`, or the path of a TOML file.
    check : callable, optional
        Further limits of a scene, reported together with the problems of its fields.
    changes : mapping, optional
        As of `Scene.replace`; fields that they replace need not be valid.

    Raises
    ------
    SceneError
        With all problems; also if there is no such scene, or its file cannot be read.
    """
    if isinstance(name_or_path, str) and name_or_path in shipped_scenes():
        content = (_SHIPPED / f"{name_or_path}{_SUFFIX}").read_bytes()
    else:
        content = _file_content(name_or_path)
    name = os.fspath(name_or_path)
    try:
        text = content.decode("utf-8-sig")  # some editors put a byte order mark first
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        problem = Problem(f"line {line}", str(error.reason), "text in UTF-8", "save the file as UTF-8")
        raise SceneError([problem], name) from None
    return parse_scene(text, name=name, check=check, changes=changes)


def parse_scene(
    text: str, *, name: str = "scene", check: Check | None = None, changes: Mapping[str, Value] | None = None
) -> Scene:
    """A scene from the text of a scene file.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        Name of the scene in errors.
    check : callable, optional
        Further limits of a scene, reported together with the problems of its fields.
    changes : mapping, optional
        As of `load_scene`.

    Raises
    ------
    SceneError
        With all problems, or the line where the TOML syntax is wrong.
    """
    data = read_toml(text, name)
    if "scene" in data and "gear_pair" not in data:
        fix = f"give its scene, or solve the study: semiwear {_study_command(data)} {name}"
        raise SceneError([Problem("scene", f"a study of the scene {data['scene']!r}", "a scene", fix)], name)
    return scene_from_dict(data, name=name, check=check, changes=changes)


def _study_command(data: Mapping[str, Value]) -> str:
    """Command that solves a study."""
    tables = {"design": "optimise", "unknown": "infer"}
    return next((command for table, command in tables.items() if table in data), "sweep")


def _file_content(name_or_path: str | os.PathLike[str]) -> bytes:
    path = Path(name_or_path)
    try:
        with no_pipe(path).open("rb") as opened:  # a device may have no end
            content = opened.read(_MOST_BYTES + 1)
            problem = _result_problem(path, opened) if content.startswith(NETCDF) else None
        if problem is None and len(content) <= _MOST_BYTES:
            return content
        found = f"{path}: more than {_MOST_BYTES:.0e} bytes"
        allowed = "the text of a scene, a few thousand bytes"
        problem = problem or Problem("scene", found, allowed, "is this the file of a scene?")
    except FileNotFoundError:
        shipped = shipped_scenes()
        fix = advised_name(path.stem, shipped, "check the path", quoted=True)
        allowed = f"the path of a scene file, or a shipped scene: {', '.join(shipped)}"
        problem = Problem("scene", f"no file {str(path)!r}", allowed, fix)
    except IsADirectoryError:
        problem = Problem("scene", str(path), "the path of a scene file", "it is a folder: give the file in it")
    except (OSError, ValueError) as error:
        problem = Problem("scene", str(path), "a readable scene file", str(error))
    raise SceneError([problem], str(path))


def _result_problem(path: Path, opened: BinaryIO) -> Problem:
    """Problem of a netCDF file given instead of a scene."""
    opened.seek(max(path.stat().st_size - 2 * len(_SEAL) - 32, 0))
    content = "this is a result of semiwear" if _SEAL in opened.read() else "this is a netCDF file"
    fix = f"{content}: give its scene, which a result has as the attribute scene_toml, or semiwear report {path}"
    return Problem("scene", str(path), "the text of a scene", fix)
