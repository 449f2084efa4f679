"""A few numbers that tell a result's variables apart from any other's."""

import zlib
from typing import Any

import numpy as np
import xarray as xr

TOLERANCE = 1e-9  # of a variable's greatest value
ELSEWHERE = 1e-6  # of it, on a processor that adds in another order: 1.2e-7 at most between AVX-512 and AVX2
_VALUES = 3
_ITERATIONS = "/iterations"  # on such a processor one more or less ends within the same tolerance
_CHANCE = ("seconds", "effect_seconds")
_NOTHING = {"/transmission_error": 1e-6}  # [arcsec]: less than that is a conjugate pair's, whose digits are rounding
_ROUNDING = ("load_balance_residual", "complementarity_residual", "wear_volume_residual")


def digest(result: xr.DataTree | xr.Dataset) -> dict[str, dict[str, Any]]:
    """Shape, missing values, extremes, three values and two projections of every variable and coordinate."""
    parts = {"": result} if isinstance(result, xr.Dataset) else result.children
    found = {}
    for group, dataset in parts.items():
        for name, array in dataset.variables.items():
            if name not in _CHANCE + _ROUNDING:
                found[f"{group}/{name}"] = _of_array(f"{group}/{name}", array.values)
    return found


def _of_array(name: str, values: np.ndarray) -> dict[str, Any]:
    told: dict[str, Any] = {"shape": list(values.shape)}
    if values.dtype.kind not in "fiub":
        return told | {"text": zlib.crc32("\n".join(map(str, values.ravel())).encode())}
    numbers = values.astype(float).ravel()
    missing = np.isnan(numbers)
    numbers = np.where(missing, 0.0, numbers)
    random = np.random.default_rng(zlib.crc32(name.encode()))
    places = np.sort(random.choice(numbers.size, min(_VALUES, numbers.size), replace=False))
    weights = random.uniform(0.5, 1.5, (2, numbers.size)) * random.choice([-1.0, 1.0], (2, numbers.size))
    return told | {
        "missing": int(missing.sum()),
        "least": _short(numbers.min(initial=0.0)),
        "greatest": _short(numbers.max(initial=0.0)),
        "values": [_short(number) for number in numbers[places]],
        "projections": [_short(number) for number in weights @ numbers / max(np.sqrt(numbers.size), 1.0)],
    }


def _greatest(told: dict[str, Any]) -> float:
    return max(abs(told["least"]), abs(told["greatest"]))


def _short(number: float) -> float:
    """To a hundredth of the tolerance, so that files stay small."""
    return float(f"{number:.12g}")


def differences(
    found: dict[str, dict[str, Any]], stored: dict[str, dict[str, Any]], tolerance: float = TOLERANCE
) -> list[str]:
    """Variables that differ by more than the tolerance times their greatest value, a line each."""
    lines = [f"{name} is new" for name in found.keys() - stored.keys()]
    lines += [f"{name} is gone" for name in stored.keys() - found.keys()]
    for name in sorted(found.keys() & stored.keys()):
        one, two = found[name], stored[name]
        exact = [key for key in ("shape", "missing", "text") if one.get(key) != two.get(key)]
        if exact:
            lines += [f"{name}: {key} {one.get(key)}, was {two.get(key)}" for key in exact]
            continue
        if "text" in two:
            continue
        scale, now = _greatest(two), _greatest(one)
        if max(scale, now) < _NOTHING.get(name, 0.0):
            continue
        counted = tolerance == ELSEWHERE and name.endswith(_ITERATIONS)
        allowed = 1.0 if counted else tolerance * scale
        for key in ("least", "greatest", "values") if counted else ("least", "greatest", "values", "projections"):
            change = float(np.max(np.abs(np.subtract(one[key], two[key])), initial=0.0))
            if not change <= allowed:
                lines.append(f"{name}: {key} {one[key]}, was {two[key]}: {change / scale if scale else change:.1e}")
                break
    return lines
