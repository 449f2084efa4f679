"""A stage of a REXS file as a scene: fields from attributes, and a list of attributes without a counterpart."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field

from semiwear.check import geometric_problems
from semiwear.errors import Problem, SceneError
from semiwear.plain_text import one_of, table
from semiwear.rexs.model import Component, RexsModel, read_model
from semiwear.scene import Scene, scene_from_dict
from semiwear.untyped import Table, Value

_BODIES = ("pinion", "gear")
_UNITS = {
    "mm": "mm", "deg": "deg", "°": "deg", "none": "none", "": "none", "-": "none", "N/mm^2": "N / mm^2",
    "MPa": "N / mm^2",  # of REXS 2
}  # fmt: skip
# attribute of a gear or its flanks: its unit, and the field of the scene
_OF_GEAR = {
    "number_of_teeth": ("none", "{}_teeth"),
    "face_width": ("mm", "{}_face_width_mm"),
    "tip_diameter": ("mm", "{}_tip_diameter_mm"),
}
# signs of a ring gear's values in a scene, for either sign in the file (in ISO 21771 its diameters are negative)
_OF_RING: dict[str, Callable[[float], float]] = {"number_of_teeth": lambda teeth: -abs(teeth), "tip_diameter": abs}
_OF_FLANK = {"addendum_modification_coefficient": ("none", "{}_profile_shift")}
_SHARED = {
    "normal_module": ("mm", "normal_module_mm"),
    "normal_pressure_angle": ("deg", "pressure_angle_deg"),
    "helix_angle_reference_diameter": ("deg", "helix_angle_deg"),
}
_OF_MATERIAL = {"elastic_modulus": ("N / mm^2", "youngs_modulus_MPa"), "poisson_ratio": ("none", "poissons_ratio")}
_POSITION = ("reference_component_for_position", "support_vector", "u_axis_vector", "w_axis_vector")
_SAME = 1e-9  # relative tolerance of values that must be equal for both gears or both flanks


@dataclass(frozen=True)
class RexsPair:
    """A scene from a REXS file: printed as a table of the fields taken and a list of the attributes left out.

    Attributes
    ----------
    scene : Scene
    taken : tuple of (field, value, where)
        Fields, their values, and the components and attributes that they come from.
    left_out : tuple of str
        Attributes of the gears, their flanks, materials and stage that have no counterpart in a scene.
    """

    scene: Scene
    taken: tuple[tuple[str, str, str], ...]
    left_out: tuple[str, ...]

    def __str__(self) -> str:
        lines = [table(("field", "value", "from"), self.taken)]
        if self.left_out:
            lines += ["", "no counterpart in a scene:", *(f"- {text}" for text in self.left_out)]
        return "\n".join(lines)


def read_rexs(
    path: str | os.PathLike[str],
    *,
    stage: str | None = None,
    pinion_torque_Nm: float | None = None,
    changes: Table | None = None,
) -> RexsPair:
    """A cylindrical stage of a REXS file (version 1 or 2; XML, JSON or zipped) as a scene.

    The gear with fewer teeth, or the mate of a ring gear, is the pinion, which drives. A ring gear has a negative
    number of teeth in the scene, for either sign in the file. Teeth, module, pressure and helix angle, hand, profile
    shifts, face widths, tip diameters, centre distance and elastic constants are taken as they are; dedendum and rims
    follow from root and inner diameters; fields that the file does not give have the defaults of a scene. Flank
    modifications, roughness, tolerances, strengths, bearings and positions along shafts have no exact counterpart and
    are listed.

    Parameters
    ----------
    path : path
    stage : str, optional
        Id of the component `cylindrical_stage`, if the file has several.
    pinion_torque_Nm : float, optional
        Torque on the pinion; needed unless exactly one load case gives the gear's `torque`.
    changes : mapping, optional
        Further fields of the scene by dotted key, such as ``{"wear.coefficient_mm2_per_N": 1e-13}``.

    Raises
    ------
    SceneError
        For a damaged file, a file without such a stage, contradictions in it, and all problems of the scene.
    """
    model = read_model(path)
    found = _Reading(model, _stage(model, stage))
    scene_table = found.scene_table(pinion_torque_Nm)
    if found.problems:
        raise SceneError(found.problems, os.fspath(path))
    scene = scene_from_dict(scene_table, name=os.fspath(path), check=geometric_problems, changes=changes)
    return RexsPair(scene, tuple(found.taken), tuple(found.left_out()))


def _stage(model: RexsModel, number: str | None) -> Component:
    stages = [part for part in model.components.values() if part.type == "cylindrical_stage"]
    chosen = [stage for stage in stages if number is None or stage.id == str(number)]
    if len(chosen) == 1:
        return chosen[0]
    ids = one_of(stage.id for stage in stages) or "a file with a component cylindrical_stage"
    found = f"{len(stages)} stages" if number is None else number
    raise SceneError.of("stage", found, ids, "name one of them" if stages else "other kinds of stages are not read")


@dataclass
class _Reading:
    """State while a stage is read: fields taken, problems, and attributes used."""

    model: RexsModel
    stage: Component
    taken: list[tuple[str, str, str]] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    used: set[tuple[str, str]] = field(default_factory=set)
    parts: list[Component] = field(default_factory=list)

    def scene_table(self, torque: float | None) -> Table:
        gears = self._gears()
        if gears is None:
            return {}
        pair: Table = {"type": "cylindrical"}
        materials: Table = {}
        for body, gear in zip(_BODIES, gears, strict=True):
            flanks = self._flanks(gear)
            self.parts += [gear, *flanks, *self._modifications(flanks)]
            for name, (unit, to) in _OF_GEAR.items():
                change = _OF_RING.get(name) if gear.type == "ring_gear" else None
                self._take(pair, to.format(body), (gear,), name, unit, change)
            for name, (unit, to) in _OF_FLANK.items():
                self._take(pair, to.format(body), (gear, *flanks), name, unit)
            self._tool_and_rim(pair, body, gear)
            materials[body] = self._material(body, gear)
        gears_and_flanks = [part for gear in gears for part in (gear, *self._flanks(gear))]
        for name, (unit, to) in _SHARED.items():
            self._take(pair, to, gears_and_flanks, name, unit, abs)
        self._hand(pair, gears)
        self.parts.append(self.stage)
        self._take(pair, "centre_distance_mm", (self.stage,), "center_distance", "mm", abs)
        operation: Table = {"pinion_torque_Nm": self._torque(gears[0], torque)}
        teeth = {key: int(value) for key, value in pair.items() if key.endswith("_teeth")}
        title = f"REXS stage {self.stage.id}" + (f": {self.stage.name}" if self.stage.name else "")
        return {"title": title, "gear_pair": pair | teeth, "material": materials, "operation": operation}

    def left_out(self) -> list[str]:
        """Unused attributes of the stage, its gears, flanks and materials."""
        return [
            f"{part}: {name}" + (f" = {entry.value} {entry.unit}".rstrip() if entry.value is not None else "")
            for part in {part.id: part for part in self.parts}.values()
            for name, entry in part.attributes.items()
            if (part.id, name) not in self.used and name not in _POSITION
        ]

    # ---- parts

    def _gears(self) -> tuple[Component, Component] | None:
        ends = next(self.model.related("stage", stage=self.stage.id), {})
        gears = [self.model.components[ends[role]] for role in ("gear_1", "gear_2") if role in ends]
        if len(gears) != 2:
            self._problem(str(self.stage), f"{len(gears)} gears", "relation stage with gear_1 and gear_2")
            return None
        teeth = [self._number(gear, "number_of_teeth", "none") for gear in gears]
        if None in teeth:
            self._problem(f"{self.stage}.number_of_teeth", None, "the number of teeth of both gears")
            return None
        ring = [gear.type == "ring_gear" for gear in gears]
        swap = ring[0] or (not ring[1] and abs(teeth[0] or 0.0) > abs(teeth[1] or 0.0))
        return (gears[1], gears[0]) if swap else (gears[0], gears[1])

    def _flanks(self, gear: Component) -> list[Component]:
        ends = next(self.model.related("flank", gear=gear.id), {})
        return [self.model.components[ends[side]] for side in ("left", "right") if side in ends]

    def _modifications(self, flanks: list[Component]) -> list[Component]:
        """Reliefs, crownings and measured deviations of flanks."""
        ids = {flank.id for flank in flanks}
        related = {end for relation in self.model.relations if ids & set(relation.ends.values())
                   for end in relation.ends.values()}  # fmt: skip
        parts = [self.model.components[number] for number in sorted(related - ids)]
        return [part for part in parts if part.type not in ("cylindrical_gear", "ring_gear")]

    def _material(self, body: str, gear: Component) -> Table:
        """Elastic constants of the gear's own material, or else of that of its shaft."""
        owners = [gear.id, *(ends["assembly"] for ends in self.model.related("assembly", part=gear.id))]
        found: Table = {}
        for owner in owners:
            for ends in self.model.related("reference", origin=owner):
                material = self.model.components[ends["referenced"]]
                if material.type != "material" or found:
                    continue
                self.parts.append(material)
                for name, (unit, to) in _OF_MATERIAL.items():
                    self._take(found, to, (material,), name, unit, shown=f"material.{body}.{to}")
                if "material_designation" in material.attributes:
                    found["name"] = str(material.attributes["material_designation"].value)
                    self.used.add((material.id, "material_designation"))
        return found

    def _tool_and_rim(self, pair: Table, body: str, gear: Component) -> None:
        """Dedendum from the root diameter, and the rim from the inner diameter."""
        root = self._number(gear, "root_diameter", "mm")
        inner = self._number(gear, "inner_diameter", "mm")
        module = self._number(gear, "normal_module", "mm")
        beta = self._number(gear, "helix_angle_reference_diameter", "deg") or 0.0
        teeth, shift = pair.get(f"{body}_teeth"), pair.get(f"{body}_profile_shift", 0.0)
        if root is not None and module is not None and teeth is not None:
            reference = module * teeth / math.cos(math.radians(beta))
            signed = math.copysign(abs(root), teeth)  # diameters of an internal gear are negative (ISO 21771)
            dedendum = 0.5 * (reference - signed) + shift * module
            self._put(pair, f"{body}_rack_addendum_mm", dedendum, gear, "root_diameter")
        if inner:
            if body == "pinion":
                self._put(pair, "pinion_bore_radius_mm", 0.5 * inner, gear, "inner_diameter")
            elif root is not None and abs(root) > inner:
                self._put(pair, "gear_rim_thickness_mm", 0.5 * (abs(root) - inner), gear, "inner_diameter")

    def _hand(self, pair: Table, gears: tuple[Component, Component]) -> None:
        """Right-hand teeth have a positive helix angle (ISO 21771); mates of external gears have opposite signs."""
        name = "helix_angle_reference_diameter"
        first, second = (self._number(gear, name, "deg") for gear in gears)
        if not first or not second:
            return
        same = (first > 0.0) == (second > 0.0)
        if same != (gears[1].type == "ring_gear"):
            found = f"{first:g} and {second:g} deg"
            self._problem(
                f"{self.stage}.{name}", found, "opposite signs of external gears, equal ones of a ring gear"
            )
        pair["hand"] = "right" if first > 0.0 else "left"
        self.taken.append(("gear_pair.hand", pair["hand"], f"{gears[0]}: {name}"))

    def _torque(self, pinion: Component, given: float | None) -> float | None:
        if given is not None:
            return given
        data = [ends["stage_gear_data"] for ends in self.model.related("stage_gear_data", gear=pinion.id)
                if ends.get("stage") == self.stage.id]  # fmt: skip
        torques = []
        for case in self.model.load_cases:
            for number in (*data, pinion.id):
                if number in case and "torque" in case[number].attributes:
                    value = self._number(case[number], "torque", "N m")
                    torques += [] if value is None else [abs(value)]
        if len(torques) == 1:
            self.taken.append(("operation.pinion_torque_Nm", f"{torques[0]:g}", f"{pinion}: torque of the load case"))
            return torques[0]
        found = f"{len(torques)} load cases that give it" if torques else None
        self._problem("pinion_torque_Nm", found, "the torque on the pinion [N m]", "give pinion_torque_Nm")
        return None

    # ---- values

    def _take(
        self, into: Table, to: str, parts: list[Component] | tuple[Component, ...], name: str, unit: str,
        change: Callable[[float], float] | None = None, shown: str | None = None,
    ) -> None:  # fmt: skip
        """Put an attribute of one or more parts, which must have equal values, into a table."""
        change = change or (lambda value: value)
        found = [(part, value) for part in parts if (value := self._number(part, name, unit)) is not None]
        values = {part.id: change(value) for part, value in found}
        if not values:
            return
        least, most = min(values.values()), max(values.values())
        if most - least > _SAME * max(abs(least), abs(most)):
            differing = " and ".join(f"{value:g}" for value in values.values())
            fix = "different flanks of a gear and different modules are not modelled"
            self._problem(f"{self.stage}.{name}", differing, "equal values", fix)
        self._put(into, to, most if most == least else next(iter(values.values())), found[0][0], name, shown)
        self.used |= {(part.id, name) for part, _ in found}

    def _put(self, into: Table, to: str, value: float, part: Component, name: str, shown: str | None = None) -> None:
        into[to] = value
        self.used.add((part.id, name))
        self.taken.append((shown or f"gear_pair.{to}", f"{value:.6g}", f"{part}: {name}"))

    def _number(self, part: Component, name: str, unit: str) -> float | None:
        if name not in part.attributes:
            return None
        found = part.attributes[name]
        if _UNITS.get(found.unit, found.unit) != unit:
            self._problem(f"{part}.{name}", f"in {found.unit!r}", f"in {unit!r}", "the unit of REXS: export it again")
        try:
            value = float(found.value)
        except (TypeError, ValueError):
            value = math.nan
        if not math.isfinite(value):
            self._problem(f"{part}.{name}", found.value, "a finite number", "export it again")
            return None
        return value

    def _problem(self, where: str, value: Value, allowed: str, fix: str = "check the file") -> None:
        problem = Problem(where, value, allowed, fix)
        if problem not in self.problems:
            self.problems.append(problem)
