"""Which word was meant: close matches for misspelled names."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher

__all__ = ["closeness", "closest"]

_CLOSE_ENOUGH = 0.6
# Longer words are no misspellings, and comparing them would take quadratic time.
_LONGEST_WORD = 80


def closeness(word: str, option: str) -> float:
    """Likeness of two names, 0 to 1, whatever their case; 0 when too unlike to suggest one for the other."""
    if len(word) > _LONGEST_WORD:
        return 0.0
    ratio = SequenceMatcher(None, word.casefold(), option.casefold(), autojunk=False).ratio()
    return ratio if ratio >= _CLOSE_ENOUGH else 0.0


def closest(word: str, options: Iterable[str]) -> str | None:
    """The option most like the word, or None when there is none like it."""
    best = max(options, key=lambda option: closeness(word, option), default=None)
    return best if best is not None and closeness(word, best) > 0.0 else None
