"""Conditions of a line contact under a multiple of its load."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

from semiwear.contact.conditions import ContactConditions


def raised(conditions: ContactConditions, factor: float) -> ContactConditions:
    """Conditions of line contacts with their loads times a factor: pressure and width grow with its square root."""
    if factor == 1.0:
        return conditions
    root = sqrt(factor)
    return replace(
        conditions,
        line_load=factor * conditions.line_load,
        half_width=root * conditions.half_width,
        pressure=root * conditions.pressure,
    )
