"""Wear states as plain arrays, and back, from which a run resumes bit for bit.

Saved are the wear, the loads and quantities that do not follow from the wear: the pace, the correction of the
implicit wear compliance, and the contact of pressed edges, which depends on the history of the loads. Footprints are
found again from the wear.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from semiwear.contact.footprint import OF_PRESSED_EDGES
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.untyped import Options
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.volume import WearVolume

_NUMBERS = ("meshes", "pace", "error", "law_residual", "depth_ratio")  # attributes of a state


def state_arrays(state: WearState) -> dict[str, np.ndarray]:
    """A wear state as arrays [mm, N, rad]; `restored_state` makes the same state from them, bit for bit."""
    arrays = {name: np.array(getattr(state, name)) for name in _NUMBERS} | {"wear": state.wear}
    arrays["stride"] = np.array(state.stride, dtype=float)
    arrays |= {f"volume.{entry.name}": getattr(state.volume, entry.name) for entry in fields(WearVolume)}
    arrays |= {f"correction.{k}": correction for k, correction in enumerate(state.corrections)}
    if state.contact.driving_wear is not None:
        arrays["driving_wear"] = state.contact.driving_wear
    for k, contact in enumerate((state.contact, *state.cases)):
        arrays |= {f"{k}.{name}": getattr(contact.coarse, name) for name in OF_PRESSED_EDGES}
        arrays[f"{k}.edge_residual"] = np.array(contact.edge_residual)
        arrays |= {f"{k}.{entry.name}": getattr(contact.loads, entry.name) for entry in fields(TeethLoads)}
    return arrays


def restored_state(stepper: WearStepper, arrays: Mapping[str, np.ndarray]) -> WearState:
    """The wear state from the arrays of `state_arrays`; `KeyError` where an array is missing."""
    all_teeth = (stepper.teeth, *(case.teeth for case in stepper.cases))
    contacts = [_contact(teeth, arrays, k) for k, teeth in enumerate(all_teeth)]
    numbers = {name: float(arrays[name]) for name in _NUMBERS}
    stride = tuple(arrays["stride"].tolist())
    kept = sum(name.startswith("correction.") for name in arrays)
    corrections = tuple(arrays[f"correction.{k}"] for k in range(kept))
    volume = WearVolume(**{entry.name: arrays[f"volume.{entry.name}"] for entry in fields(WearVolume)})
    return WearState(
        contact=contacts[0],
        cases=tuple(contacts[1:]),
        stride=stride,
        volume=volume,
        corrections=corrections,
        **numbers,
    )


def _contact(teeth: LoadedTeeth, arrays: Mapping[str, np.ndarray], k: int) -> LoadedState:
    wear, driving = arrays["wear"], arrays.get("driving_wear")
    touched = teeth.touch_solved(wear, driving)
    loads = TeethLoads(**{entry.name: arrays[f"{k}.{entry.name}"] for entry in fields(TeethLoads)})
    pressed: Options = {name: arrays[f"{k}.{name}"] for name in OF_PRESSED_EDGES}
    residual = float(arrays[f"{k}.edge_residual"])
    return LoadedState(wear, touched, replace(touched, **pressed), loads, driving, residual)
