"""Names of varied fields in a dataset: as short as is unambiguous."""

from __future__ import annotations

from collections.abc import Iterable

from semiwear.results import COORDINATES, VARIABLES

OWN = ("sample", "status", "message", "seconds", "last_wear_step")
"""Names that every sweep uses."""

_TAKEN = frozenset({*COORDINATES, *(name for _, name in VARIABLES), *OWN})


def short_names(keys: Iterable[str]) -> dict[str, str]:
    """Last parts of dotted keys, with as many before them as are needed to distinguish them.

    Names of results are never taken: ``wear.until.meshes`` is ``until_meshes``.
    """
    parts = {key: key.split(".") for key in keys}
    length = dict.fromkeys(parts, 1)
    while True:
        names = {key: "_".join(parts[key][-length[key] :]) for key in parts}
        all_names = list(names.values())
        unclear = [key for key, name in names.items() if name in _TAKEN or all_names.count(name) > 1]
        longer = [key for key in unclear if length[key] < len(parts[key])]
        if not longer:
            return {key: f"{name}_varied" if name in _TAKEN else name for key, name in names.items()}
        for key in longer:
            length[key] += 1
