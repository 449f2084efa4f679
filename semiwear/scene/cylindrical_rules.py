"""Rules over several fields of a cylindrical gear pair that need no tooth geometry."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from semiwear.errors import Problem
from semiwear.scene.across import RuleBook, across
from semiwear.scene.cross_rules import mm
from semiwear.scene.defaults import full_round_radius

CYLINDRICAL_CROSS_RULES: RuleBook = []
_across = partial(across, CYLINDRICAL_CROSS_RULES)


@_across("gear_pair", "pinion_teeth", "gear_teeth")
def _ring_is_larger_than_its_pinion(pinion_teeth: int, gear_teeth: int) -> Iterator[Problem]:
    if -pinion_teeth <= gear_teeth < 0:
        fix = "an internal gear has more teeth than its pinion, usually ten more at least"
        yield Problem("gear_pair.gear_teeth", gear_teeth, f"below {-pinion_teeth}", fix)


@_across("gear_pair", "pinion_face_width_mm", "gear_face_width_mm", "face_offset_mm")
def _faces_share_the_middle(pinion: float, gear: float, offset: float) -> Iterator[Problem]:
    if abs(offset) >= pinion / 2.0:
        allowed = f"above {mm(-pinion / 2.0)} and below {mm(pinion / 2.0)} mm"
        fix = "the pinion must cover the middle of the gear's face"
        yield Problem("gear_pair.face_offset_mm", offset, allowed, fix)


for _body in ("pinion", "gear"):

    @_across(
        "gear_pair",
        "normal_module_mm",
        "pressure_angle_deg",
        f"{_body}_rack_addendum_mm",
        f"{_body}_rack_tip_radius_mm",
        "gear_teeth",
    )
    def _rack_crest_can_be_rounded(
        module: float, alpha_deg: float, addendum: float, radius: float, gear_teeth: int, body: str = _body
    ) -> Iterator[Problem]:
        if body == "gear" and gear_teeth < 0:
            return  # its fillet is an arc in the tooth space, which is checked with the tooth geometry
        greatest = full_round_radius(module, alpha_deg, addendum)
        if greatest < 0.0:
            allowed = "less: the rack's flanks cross below its crest"
            fix = "lower the addendum, usually 1.25 modules, or the pressure angle"
            yield Problem(f"gear_pair.{body}_rack_addendum_mm", addendum, allowed, fix)
        elif radius > greatest:
            fix = f"the crest is fully round at {mm(greatest)} mm: give less, or lower {body}_rack_addendum_mm"
            yield Problem(f"gear_pair.{body}_rack_tip_radius_mm", radius, f"0 to {mm(greatest)} mm", fix)


@_across("wear", "wear.until.control_depths_um", "wear.control_point.face_mm")
def _control_point_is_given(depths: tuple[float, ...] | None, face: float | None) -> Iterator[Problem]:
    if depths is not None and face is None:
        allowed = "a table with face_mm and height_mm"
        fix = "needed by [wear.until] control_depths_um: add it, or give meshes instead"
        yield Problem("wear.control_point", None, allowed, fix)


@_across("gear_pair", "gear_face_width_mm", "pinion_face_width_mm", "face_offset_mm", "wear.control_point.face_mm")
def _control_point_is_in_the_face(gear: float, pinion: float, offset: float, face: float | None) -> Iterator[Problem]:
    low, high = max(-gear / 2.0, offset - pinion / 2.0), min(gear / 2.0, offset + pinion / 2.0)
    if face is not None and not low <= face <= high:
        allowed = f"{mm(low)} to {mm(high)} mm, the part of the gear's face that the pinion covers"
        yield Problem("wear.control_point.face_mm", face, allowed, "counted from the middle of the gear's face")
