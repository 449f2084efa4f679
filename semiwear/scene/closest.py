"""Close matches for misspelled names."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher

_CLOSE_ENOUGH = 0.6
# Closeness of a name whose words all occur in the option, such as torque in pinion_torque_Nm.
_WORDS_WITHIN = 0.9
_UNITS = frozenset("mm um m N Nm kNm MPa GPa Pa deg rad mrad arcsec rpm C HV kN per".casefold().split())
# Longer words are not misspellings, and comparing them would take quadratic time.
_LONGEST_WORD = 80


def closeness(word: str, option: str) -> float:
    """Similarity of two names, 0 to 1, ignoring case; 0 if too small to suggest one for the other."""
    if len(word) > _LONGEST_WORD:
        return 0.0
    ratio = SequenceMatcher(None, word.casefold(), option.casefold(), autojunk=False).ratio()
    words = _words(word)
    if words and words <= _words(option):
        ratio = max(ratio, _WORDS_WITHIN)
    return ratio if ratio >= _CLOSE_ENOUGH else 0.0


def _words(name: str) -> frozenset[str]:
    """Words of a name in snake case, without its unit."""
    return frozenset(name.casefold().split("_")) - _UNITS - {""}


def closest(word: str, options: Iterable[str]) -> str | None:
    """The option closest to the word, or None if none is close."""
    best = max(options, key=lambda option: closeness(word, option), default=None)
    return best if best is not None and closeness(word, best) > 0.0 else None


def advised_name(word: str, options: Iterable[str], otherwise: str, *, quoted: bool = False) -> str:
    """Advice on a misspelt name: the closest option, in quotes where text stands in a file, or what else to do."""
    meant = closest(word, options)
    if meant is None:
        return otherwise
    return f'did you mean "{meant}"?' if quoted else f"did you mean {meant}?"
