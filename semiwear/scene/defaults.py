"""Defaults that follow from other fields of a gear pair; the table of the face gear.

One table serves the dataclass, which fills them in, and the rules across fields, which test them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["DERIVED_DEFAULTS", "DerivedDefault", "filled_in"]


@dataclass(frozen=True)
class DerivedDefault:
    """A default computed from other fields.

    Attributes
    ----------
    needs : tuple of str
        Field names of the gear pair that the formula takes, in order.
    formula : callable
        From those values to the default.
    """

    needs: tuple[str, ...]
    formula: Callable[..., float]


def filled_in(pair: Any, defaults: Mapping[str, DerivedDefault]) -> frozenset[str]:
    """Fill a pair's fields that are None with their defaults, in the order of the table; the fields' names."""
    derived = [name for name in defaults if getattr(pair, name) is None]
    for name in derived:
        default = defaults[name]
        object.__setattr__(pair, name, default.formula(*(getattr(pair, need) for need in default.needs)))
    return frozenset(derived)


def _modules(factor: float) -> DerivedDefault:
    """Default proportional to the module, free of binary noise in the last digits."""
    return DerivedDefault(("module_mm",), lambda module_mm: float(f"{factor * module_mm:.12g}"))


def _face_centre(inner_mm: float, outer_mm: float) -> float:
    return 0.5 * (inner_mm + outer_mm)


def _bore_radius(module_mm: float, pinion_teeth: int) -> float:
    # Two digits: a bore is a drawing dimension, and the ratio 0.63 is itself a convention.
    return float(f"{0.63 * 0.5 * module_mm * pinion_teeth:.2g}")


DERIVED_DEFAULTS: dict[str, DerivedDefault] = {
    "pinion_centre_mm": DerivedDefault(("gear_inner_radius_mm", "gear_outer_radius_mm"), _face_centre),
    "pinion_addendum_mm": _modules(1.0),
    "gear_addendum_mm": _modules(1.0),
    "shaper_addendum_mm": _modules(1.25),
    "rack_addendum_mm": _modules(1.25),
    "shaper_tip_radius_mm": _modules(0.2),
    "rack_tip_radius_mm": _modules(0.3),
    "pinion_bore_radius_mm": DerivedDefault(("module_mm", "pinion_teeth"), _bore_radius),
    "gear_rim_thickness_mm": _modules(2.5),
}
