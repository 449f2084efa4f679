"""The scene: all inputs of a simulation, as one immutable value that is read from and written to TOML."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from html import escape

from semiwear.errors import Problem, SceneError
from semiwear.html_text import folded_html, html_table
from semiwear.scene.assemble import examined, further_problems, with_origin
from semiwear.scene.edit import edited
from semiwear.scene.model import SceneTables
from semiwear.scene.named_data import with_named_data
from semiwear.scene.schema import INLINE_TABLES, built_tables, to_dict
from semiwear.scene.toml_io import flat, write_toml
from semiwear.untyped import Table, Value

_FOLDED = ("material", "numerics")  # tables that a notebook shows folded


@dataclass(frozen=True, kw_only=True)
class Scene(SceneTables):
    """All inputs of a simulation; immutable and hashable.

    Attributes
    ----------
    title : str
        Free text. Default empty.
    reference : str or None
        Published figures to compare with: ``"seed_paper"``. Default None.
    gear_pair, material, operation, wear, numerics
        The tables; ``wear`` is None for loaded contact only.
    effects : Effects
        Optional effects; each is active if and only if its table is present. Default none.
    """

    # `replace` applies the check with which the scene was loaded
    _check: Check | None = field(default=None, repr=False, compare=False)

    def replace(self, changes: Mapping[str, Value]) -> Scene:
        """A copy with some fields changed, checked like a loaded scene.

        Parameters
        ----------
        changes : mapping
            From dotted key, e.g. ``"operation.pinion_torque_Nm"``, to the new value. None removes a field
            (back to its default) or a table. An empty mapping adds an effect with its defaults:
            ``{"effects.friction": {}}``. Setting one of ``wear.until.meshes``, ``wear.until.hours`` and
            ``wear.until.control_depths_um`` removes the others. Derived defaults are computed anew.

        Raises
        ------
        SceneError
            With all problems of the new scene, unknown keys included.

        Examples
        --------
        >>> import semiwear as sw
        >>> scene = sw.load_scene("spur_fzg_c").replace({"operation.pinion_torque_Nm": 250.0, "effects.friction": {}})
        >>> scene.operation.pinion_torque_Nm
        250.0
        >>> scene.effects.friction.coefficient
        0.05
        """
        data = to_dict(self, without_derived=True)
        return scene_from_dict(data, name=self.title or "scene", check=self._check, changes=changes)

    def to_dict(self) -> Table:
        """The scene as nested dicts of plain values, every default written out."""
        return to_dict(self)

    def to_toml(self) -> str:
        """The scene as TOML text with every number written out; `parse_scene` returns an equal scene."""
        return write_toml(self.to_dict(), inline=INLINE_TABLES)

    def _repr_html_(self) -> str:
        tables = {
            name: [(key, str(value)) for key, value in flat(entries)]
            for name, entries in self.to_dict().items()
            if isinstance(entries, dict)
        }
        head = ("field", "value")
        shown = [html_table(head, rows, name) for name, rows in tables.items() if name not in _FOLDED]
        hidden = [folded_html(name, html_table(head, tables[name])) for name in tables if name in _FOLDED]
        title = f"<p><b>{escape(self.title or 'scene')}</b>: {escape(self.gear_pair.description)}</p>"
        return "".join([title, *shown, *hidden])

    @property
    def sha256(self) -> str:
        """Hexadecimal SHA-256 of `to_toml`: equal for equal scenes."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()


Check = Callable[[Scene], Sequence[Problem]]
"""Function of a scene that checks further limits, e.g. geometric ones, and returns problems."""


def scene_from_dict(
    data: Mapping[str, Value],
    *,
    name: str = "scene",
    check: Check | None = None,
    changes: Mapping[str, Value] | None = None,
) -> Scene:
    """A scene from nested mappings with the layout of a scene file.

    Parameters
    ----------
    data : mapping
        Tables and fields; None for a field left out.
    name : str
        Name of the scene in errors.
    check : callable, optional
        Further limits; applied when every field is within its range, and kept for `Scene.replace`.
    changes : mapping, optional
        As of `Scene.replace`; fields that they replace need not be valid.

    Raises
    ------
    SceneError
        With all problems.
    """
    known = list[Problem]()
    if changes:
        data, known = edited(with_named_data(data), changes)
    reading, found = examined(data, known)
    if not reading.complete:
        raise SceneError(with_origin(found, reading), name)
    scene = Scene(**built_tables(reading.schema, reading.given, reading.tables), _check=check)
    if check is not None:
        found += further_problems(partial(check, scene), found)
    if found:
        raise SceneError(with_origin(found, reading), name)
    return scene
