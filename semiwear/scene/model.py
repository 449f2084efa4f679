"""The scene: frozen dataclasses, one for each table of the scene file.

Units are in the field names. The constructors fill in defaults and check nothing; `load_scene`,
`parse_scene`, `scene_from_dict` and `Scene.replace` check everything.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from semiwear.errors import Problem
from semiwear.scene.gear_pair import FaceGearPair

__all__ = [
    "Check",
    "ControlPoint",
    "FaceGearPair",
    "Material",
    "Materials",
    "Numerics",
    "Operation",
    "Scene",
    "Wear",
    "WearUntil",
]


@dataclass(frozen=True, kw_only=True)
class Material:
    """Table ``[material.pinion]`` or ``[material.gear]``: an isotropic elastic body. Default: steel."""

    name: str = "steel"
    youngs_modulus_MPa: float = 207000.0
    poissons_ratio: float = 0.3


@dataclass(frozen=True, kw_only=True)
class Materials:
    """The materials of both bodies."""

    pinion: Material = Material()
    gear: Material = Material()


@dataclass(frozen=True, kw_only=True)
class Operation:
    """Table ``[operation]``: how the pair runs.

    Attributes
    ----------
    pinion_torque_Nm : float
        Torque on the pinion (driving), required.
    loaded_flank : str
        ``"drive"`` (default) or ``"coast"``, its mirror image.
    """

    pinion_torque_Nm: float
    loaded_flank: str = "drive"


@dataclass(frozen=True, kw_only=True)
class WearUntil:
    """Table ``[wear.until]``: where a wear run ends; exactly one of the two fields is set.

    Attributes
    ----------
    meshes : float or None
        Engagements of one gear tooth.
    control_depths_um : tuple of float or None
        Wear depths at the control point, increasing; each is a step of the result, the last one ends the run.
    """

    meshes: float | None = None
    control_depths_um: tuple[float, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class ControlPoint:
    """Table ``[wear.control_point]``: the point of the gear flank whose wear depth is watched.

    Attributes
    ----------
    radius_mm : float
        Gear radius.
    height_mm : float
        Height above the pitch plane, negative on the dedendum.
    """

    radius_mm: float
    height_mm: float


@dataclass(frozen=True, kw_only=True)
class Wear:
    """Table ``[wear]``: Archard wear. A scene without it is loaded contact only.

    Attributes
    ----------
    coefficient_mm2_per_N : float
        Wear coefficient k: worn depth = k * pressure * sliding distance; required.
    until : WearUntil
        Where the run ends; required.
    worn_bodies : tuple of str
        Bodies that wear. Default ``("gear",)``, the only choice now.
    control_point : ControlPoint or None
        Needed by ``control_depths_um``. Default None.
    """

    coefficient_mm2_per_N: float
    until: WearUntil
    worn_bodies: tuple[str, ...] = ("gear",)
    control_point: ControlPoint | None = None


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """Table ``[numerics]``: models and resolution.

    Attributes
    ----------
    fidelity : str
        Contact model: ``"line"`` (default, line loads with Hertz across them) or ``"patch"`` (pressure resolved in
        two dimensions).
    wear_mapping : str
        ``"interpolated"`` (default, few roll positions) or ``"marched"`` (many, summed where it happens; needs
        fidelity ``"patch"``).
    wear_scheme : str
        ``"implicit"`` (default) or ``"explicit"`` (for comparison).
    wear_steps : int or "auto"
        Steps up to ``wear.until.meshes``. Default ``"auto"``.
    roll_positions : int
        Roll positions per mesh cycle. Default 24.
    face_slices : int
        Slices along the face width. Default 61.
    cells_per_half_width : int
        Cells of a patch across the Hertz half-width at the pitch point. Default 8.
    profile_points : int
        Points of the flank grid along the tooth height. Default 141.
    tooth_pairs : int or "auto"
        Tooth pairs that may share the load. Default ``"auto"``.
    tooth_compliance : str
        ``"prism"`` (default, finite prisms), ``"rigid"`` (local contact alone) or a netCDF file of influence data.
    harmonics : int
        Cosine terms of the prism series along the face width. Default 33.
    max_iterations : int
        Iterations of the load sharing at one roll position. Default 60.
    """

    fidelity: str = "line"
    wear_mapping: str = "interpolated"
    wear_scheme: str = "implicit"
    wear_steps: int | str = "auto"
    roll_positions: int = 24
    face_slices: int = 61
    cells_per_half_width: int = 8
    profile_points: int = 141
    tooth_pairs: int | str = "auto"
    tooth_compliance: str = "prism"
    harmonics: int = 33
    max_iterations: int = 60


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
    """

    title: str = ""
    reference: str | None = None
    gear_pair: FaceGearPair
    material: Materials = Materials()
    operation: Operation
    wear: Wear | None = None
    numerics: Numerics = Numerics()
    # Kept so that `replace` applies the limits under which the scene was loaded.
    _check: Check | None = field(default=None, repr=False, compare=False)

    def replace(self, changes: Mapping[str, Any]) -> Scene:
        """A copy with some fields changed, checked like a loaded scene.

        Parameters
        ----------
        changes : mapping
            From dotted key, e.g. ``"operation.pinion_torque_Nm"``, to the new value. None removes a field
            (back to its default) or a table. Setting one of ``wear.until.meshes`` and
            ``wear.until.control_depths_um`` removes the other. Derived defaults follow.

        Raises
        ------
        SceneError
            With every problem of the new scene, unknown keys included.
        """
        from semiwear.scene.edit import replace_fields  # builds scenes, hence imports this module

        return replace_fields(self, changes)

    def to_dict(self) -> dict[str, Any]:
        """The scene as nested dicts of plain values, every default written out."""
        from semiwear.scene.schema import to_dict

        return to_dict(self)

    def to_toml(self) -> str:
        """The scene as a TOML file with every number written out; `parse_scene` gives an equal scene back."""
        from semiwear.scene.toml_io import write_toml

        return write_toml(self.to_dict())

    @property
    def sha256(self) -> str:
        """Hexadecimal SHA-256 of `to_toml`: equal for equal scenes."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()


Check = Callable[[Scene], Sequence[Problem]]
"""Further limits of a scene, e.g. geometric ones; returns what is wrong."""
