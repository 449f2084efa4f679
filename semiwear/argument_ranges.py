"""Ranges of numbers that public functions on plain arrays take."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike


def require_range(
    name: str,
    values: ArrayLike,
    unit: str = "",
    *,
    above: float = -inf,
    least: float = -inf,
    below: float = inf,
    most: float = inf,
    missing: bool = False,
    hint: str = "",
) -> None:
    """Refuse numbers out of their range, and infinite ones.

    Parameters
    ----------
    name : str
        What the numbers are, to be followed by "must be".
    values : array
    unit : str
    above, least, below, most : float
        Borders of the range, the first and the third out of it.
    missing : bool
        Whether numbers may be missing (NaN). Default: no.
    hint : str
        What to do, if the range does not tell.

    Raises
    ------
    ValueError
        Some number is out of range; with the first such number.
    """
    given = np.asarray(values)
    right = np.isfinite(given) & (given > above) & (given >= least) & (given < below) & (given <= most)
    if missing:
        right |= np.isnan(given)
    if right.all():
        return
    borders = {"above": above, "at least": least, "below": below, "at most": most}
    allowed = " and ".join(f"{word} {border:.6g}" for word, border in borders.items() if np.isfinite(border))
    wrong = given[~right].flat[0]
    raise ValueError(
        f"{name} must be {allowed or 'a number'} {unit}".rstrip() + f", not {wrong:g}{hint and f': {hint}'}"
    )
