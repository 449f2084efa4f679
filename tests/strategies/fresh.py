"""Settings of properties that draw new examples at every run."""

from __future__ import annotations

from hypothesis import settings

__all__ = ["fresh"]

fresh = settings(derandomize=False)
"""The seed is printed by `conftest.py`; these properties are cheap and hold for whatever is drawn."""
