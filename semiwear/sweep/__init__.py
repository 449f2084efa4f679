"""Sweeps: one scene with some of its fields varied, computed here or elsewhere, as one labelled dataset."""

from __future__ import annotations

from semiwear.sweep.run import sweep

__all__ = ["sweep"]
