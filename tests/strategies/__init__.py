"""Hypothesis strategies, one module for each kind of object."""

from tests.strategies.scenes import placements, scenes

__all__ = ["placements", "scenes"]
