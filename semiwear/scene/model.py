"""The tables of a scene: frozen dataclasses, one for each table of the scene file.

Units are in the field names. The constructors fill in defaults and check nothing; `load_scene`,
`parse_scene`, `scene_from_dict` and `Scene.replace` check everything.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from semiwear.scene.declare import declared
from semiwear.scene.effects import Effects
from semiwear.scene.kinds import GearPair
from semiwear.scene.rule import anything, choice
from semiwear.scene.tables import Materials, Numerics, Operation, Wear, default_worn_bodies


@dataclass(frozen=True, kw_only=True)
class SceneTables:
    """The tables of a `Scene`, without its methods for reading, changing and writing."""

    title: str = declared(anything(), "Free text.", default="")
    reference: str | None = declared(
        choice("seed_paper", otherwise="leave the field out when there is nothing to compare with"),
        "Published figures to compare with.",
        default=None,
    )
    gear_pair: GearPair
    material: Materials = field(default_factory=Materials)
    operation: Operation
    wear: Wear | None = None
    numerics: Numerics = field(default_factory=Numerics)
    effects: Effects = field(default_factory=Effects)

    def __post_init__(self) -> None:
        self._fill_in_meshes()
        wear = self.wear
        if wear is not None and not wear.worn_bodies:
            pair, mapping = type(self.gear_pair), self.numerics.wear_mapping
            bodies = default_worn_bodies(pair.both_wear, wear.coefficient_mm2_per_N, mapping)
            object.__setattr__(self, "wear", replace(wear, worn_bodies=bodies, _derived=True))

    def _fill_in_meshes(self) -> None:
        """Set the meshes of a run that ends after hours: revolutions of the gear, z1/z2 times those of the pinion."""
        wear, speed = self.wear, self.operation.pinion_speed_rpm
        if wear is None or wear.until.hours is None or speed is None:
            return
        pair = self.gear_pair
        meshes = 60.0 * wear.until.hours * speed * pair.pinion_teeth / abs(pair.gear_teeth)
        object.__setattr__(self, "wear", replace(wear, until=replace(wear.until, meshes=meshes, _derived=True)))
