"""Numbers that compiled transforms `load`, `store`, add and multiply together: vectors, or single numbers.

Vectors use internal parts of numba (`vector_lanes`). If a release of numba does not have them, or computes other
values with them, a warning is given and the same transforms run on single numbers: the same results to rounding, four
to eight times slower. The compiled code is then kept in a separate folder.
"""

from __future__ import annotations

import warnings
from types import ModuleType

import numba
import numpy as np
from numpy.typing import DTypeLike

from semiwear.kernel_cache import keep_apart, njit
from semiwear.untyped import CompilerPart


@njit(cache=True)
def _one(array):  # type: ignore[no-untyped-def]
    """Numbers that `load` reads: one."""
    return 1


@njit(cache=True)
def _load_one(source, index, like):  # type: ignore[no-untyped-def]
    """A number of a flat array, in the precision of the array `like`."""
    return like.dtype.type(source[index])


@njit(cache=True)
def _store_one(target, index, value):  # type: ignore[no-untyped-def]
    """Write a number into a flat array."""
    target[index] = value


def _vectors() -> ModuleType | None:
    """The module of vectors; None where they do not work."""
    try:
        from semiwear.compliance import vector_lanes

        return vector_lanes if vector_lanes.work() else None
    except Exception:  # any part that a release of numba no longer has
        return None


lanes_of: CompilerPart = _one
load: CompilerPart = _load_one
store: CompilerPart = _store_one
_found = _vectors()
VECTORISED = _found is not None
"""Whether transforms use vectors."""
if _found is not None:
    lanes_of, load, store = _found.lanes_of, _found.load, _found.store
else:
    warnings.warn(
        f"numba {numba.__version__} does not take semiwear's vectors: Fourier transforms run on single numbers, with "
        "the same results but four to eight times slower; a newer semiwear, or an older numba, is faster",
        RuntimeWarning,
        stacklevel=2,
    )
    keep_apart("single-numbers")


def lane_count(dtype: DTypeLike) -> int:
    """Count of numbers of a type that are loaded together."""
    return 1 if _found is None else _found.BYTES // np.dtype(dtype).itemsize
