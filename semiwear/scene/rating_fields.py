"""Base of the tables of failure modes, and the fields that they have in common."""

from __future__ import annotations

from typing import ClassVar

from semiwear.scene.declare import declared
from semiwear.scene.effect_table import EffectTable
from semiwear.scene.rule import Rule, between
from semiwear.scene.values import number
from semiwear.untyped import Value


class RatingTable(EffectTable):
    """Base of the tables of failure modes: they tell of a run and change nothing in it.

    Each declares the fields of both load factors at its own place.
    """

    acts_in: ClassVar[str] = "results"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    application_factor: float
    dynamic_factor: float

    @property
    def load_factor(self) -> float:
        """K_A K_v, by which the load of a run is raised."""
        return self.application_factor * self.dynamic_factor


def usual_range(low: float, high: float, unit: str, usual: str) -> Rule:
    """A number from one limit to another; where it is missing, the message tells the usual range."""
    allowed = f"{low:g} to {high:g} {unit}".rstrip() + f"; usual: {usual}"
    return Rule(number, allowed, lambda value: low <= value <= high, usual)


def usual_above(high: float, unit: str, usual: str) -> Rule:
    """A number above 0, up to a limit; where it is missing, the message tells the usual range."""
    allowed = f"above 0, up to {high:g} {unit}".rstrip() + f"; usual: {usual}"
    return Rule(number, allowed, lambda value: 0.0 < value <= high, usual)


def factor(symbol: str, what: str, low: float, high: float) -> Value:
    """A factor of a rating, 1 where it is left out."""
    return declared(between(number, low, high, f"{symbol}; 1 for none"), what, default=1.0)


def outer_load_factor() -> Value:
    """Field of the application factor K_A."""
    return factor("K_A", "Application factor K_A: overloads from outside that the torque leaves out.", 0.1, 10.0)


def inner_load_factor() -> Value:
    """Field of the dynamic factor K_v."""
    what = "Dynamic factor K_v: inner dynamic loads, which a run does not compute (it is quasi-static)."
    return factor("K_v", what, 0.1, 10.0)


def limit_of_safety(symbol: str, default: float) -> Value:
    """Field of the safety that is required."""
    rule = between(number, 0.1, 10.0, f"{symbol}: {default:g} is usual")
    return declared(rule, f"Required safety {symbol}, below which the pair counts as failed.", default=default)
