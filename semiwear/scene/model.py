"""The scene: frozen dataclasses, one for each table of the scene file.

Units are in the field names. The constructors fill in defaults and check nothing; `load_scene`,
`parse_scene`, `scene_from_dict` and `Scene.replace` check everything.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from semiwear.errors import Problem
from semiwear.scene.bodies import BodyCoefficients
from semiwear.scene.cylindrical import CylindricalControlPoint, CylindricalPair
from semiwear.scene.declare import declared
from semiwear.scene.effects import Effects
from semiwear.scene.flank_points import FlankPointsControlPoint, FlankPointsPair
from semiwear.scene.gear_pair import FaceGearPair
from semiwear.scene.rule import anything, choice
from semiwear.scene.tables import (
    ControlPoint,
    Material,
    Materials,
    Numerics,
    Operation,
    Wear,
    WearUntil,
    default_worn_bodies,
)
from semiwear.untyped import Table, Value

__all__ = [
    "BodyCoefficients",
    "Check",
    "ControlPoint",
    "CylindricalControlPoint",
    "CylindricalPair",
    "Effects",
    "FaceGearPair",
    "FlankPointsControlPoint",
    "FlankPointsPair",
    "Material",
    "Materials",
    "Numerics",
    "Operation",
    "Scene",
    "Wear",
    "WearUntil",
]


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything a simulation needs to know; immutable and hashable.

    Attributes
    ----------
    title : str
        Free text. Default empty.
    reference : str or None
        Published figures to compare with: ``"seed_paper"``. Default None.
    gear_pair, material, operation, wear, numerics
        The tables; ``wear`` is None when only loaded contact is asked for.
    effects : Effects
        Optional physics: an effect runs if and only if its table is there. Default none.
    """

    title: str = declared(anything(), "Free text.", default="")
    reference: str | None = declared(
        choice("seed_paper", otherwise="leave the field out when there is nothing to compare with"),
        "Published figures to compare with.",
        default=None,
    )
    gear_pair: FaceGearPair | CylindricalPair | FlankPointsPair
    material: Materials = field(default_factory=Materials)
    operation: Operation
    wear: Wear | None = None
    numerics: Numerics = field(default_factory=Numerics)
    effects: Effects = field(default_factory=Effects)
    # Kept so that `replace` applies the limits under which the scene was loaded.
    _check: Check | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        wear = self.wear
        if wear is not None and not wear.worn_bodies:
            pair, mapping = self.gear_pair.type, self.numerics.wear_mapping
            bodies = default_worn_bodies(pair, wear.coefficient_mm2_per_N, mapping)
            object.__setattr__(self, "wear", replace(wear, worn_bodies=bodies, _derived=True))

    def replace(self, changes: Mapping[str, Value]) -> Scene:
        """A copy with some fields changed, checked like a loaded scene.

        Parameters
        ----------
        changes : mapping
            From dotted key, e.g. ``"operation.pinion_torque_Nm"``, to the new value. None removes a field
            (back to its default) or a table. An empty mapping adds an effect with its defaults:
            ``{"effects.friction": {}}``. Setting one of ``wear.until.meshes`` and
            ``wear.until.control_depths_um`` removes the other. Derived defaults follow.

        Raises
        ------
        SceneError
            With every problem of the new scene, unknown keys included.
        """
        from semiwear.scene.edit import replace_fields  # builds scenes, hence imports this module

        return replace_fields(self, changes)

    def to_dict(self) -> Table:
        """The scene as nested dicts of plain values, every default written out."""
        from semiwear.scene.schema import to_dict

        return to_dict(self)

    def to_toml(self) -> str:
        """The scene as a TOML file with every number written out; `parse_scene` gives an equal scene back."""
        from semiwear.scene.schema import INLINE_TABLES
        from semiwear.scene.toml_io import write_toml

        return write_toml(self.to_dict(), inline=INLINE_TABLES)

    @property
    def sha256(self) -> str:
        """Hexadecimal SHA-256 of `to_toml`: equal for equal scenes."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()


Check = Callable[[Scene], Sequence[Problem]]
"""Further limits of a scene, e.g. geometric ones; returns what is wrong."""
