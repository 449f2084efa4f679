"""Helpers that the rules of the seed paper's comparisons share."""

from __future__ import annotations

from semiwear.report.comparison import Outcome
from semiwear.report.markup import figure_text
from semiwear.report.trends import Trend

__all__ = ["NOT_STATED", "both", "number", "within"]

NOT_STATED = "The paper states neither torque nor materials, tooth heights or fillets; here they are the scene's."


def number(published: float, value: float, tolerance: float, unit: str, why: str) -> Outcome:
    """Agreement of one number within a relative tolerance."""
    deviation = value / published - 1.0
    return Outcome(f"{figure_text(value)} {unit} ({deviation:+.1%})", abs(deviation) <= tolerance, why)


def both(first: Trend, second: Trend, why: str) -> Outcome:
    """Agreement of two trends at once."""
    return Outcome(f"{first.text}; {second.text}", first.holds and second.holds, why)


def within(tolerance: float) -> str:
    """Rule of a number, in words."""
    return f"Agrees within {tolerance:.0%}."
