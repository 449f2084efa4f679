"""Scatter: distributions of a scene's fields, and the resulting ones of its life and of measured quantities."""

from __future__ import annotations

from semiwear.scatter.distributions import LogNormal, Normal, Triangular, Uniform, usual_wear_coefficient
from semiwear.scatter.run import scatter
from semiwear.scatter.statistics import Scatter

__all__ = ["LogNormal", "Normal", "Scatter", "Triangular", "Uniform", "scatter", "usual_wear_coefficient"]
