"""Base class of the tables of failure modes, and their common fields."""

from __future__ import annotations

from typing import ClassVar

from semiwear.scene.declare import declared
from semiwear.scene.effect_table import EffectTable
from semiwear.scene.rule import Rule, between
from semiwear.scene.values import number
from semiwear.untyped import Value


class RatingTable(EffectTable):
    """Base class of the tables of failure modes, which are rated after a run and do not change it.

    Each declares the fields of both load factors itself, which sets their order.
    """

    acts_in: ClassVar[str] = "results"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    application_factor: float
    dynamic_factor: float

    @property
    def load_factor(self) -> float:
        """K_A K_v, by which the load of a run is multiplied."""
        return self.application_factor * self.dynamic_factor


def usual_range(low: float, high: float, unit: str, usual: str) -> Rule:
    """A number between two limits; the message also gives the usual range."""
    allowed = f"{low:g} to {high:g} {unit}".rstrip() + f"; usual: {usual}"
    return Rule(number, allowed, lambda value: low <= value <= high, usual)


def usual_above(high: float, unit: str, usual: str) -> Rule:
    """A number above 0, up to a limit; the message also gives the usual range."""
    allowed = f"above 0, up to {high:g} {unit}".rstrip() + f"; usual: {usual}"
    return Rule(number, allowed, lambda value: 0.0 < value <= high, usual)


def factor(symbol: str, meaning: str, low: float, high: float) -> Value:
    """Field of a factor of a rating, with the default 1."""
    return declared(between(number, low, high, f"{symbol}; 1 for none"), meaning, default=1.0)


def outer_load_factor() -> Value:
    """Field of the application factor K_A."""
    return factor("K_A", "Application factor K_A: external overloads that the torque does not include.", 0.1, 10.0)


def inner_load_factor() -> Value:
    """Field of the dynamic factor K_v."""
    meaning = "Dynamic factor K_v: inner dynamic loads, which a run does not compute (it is quasi-static)."
    return factor("K_v", meaning, 0.1, 10.0)


def limit_of_safety(symbol: str, default: float) -> Value:
    """Field of the required safety."""
    rule = between(number, 0.1, 10.0, f"{symbol}: {default:g} is usual")
    return declared(rule, f"Required safety {symbol}, below which the pair counts as failed.", default=default)
