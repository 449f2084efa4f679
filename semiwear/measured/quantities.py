"""Names, units and sources of the quantities in the datasets of measured flanks."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError

_ISO_1328 = "ISO 1328-1:2013, Cylindrical gears: flank tolerance classification"
_ISO_1122 = "ISO 1122-1:1998, Vocabulary of gear terms"
_SEBER = "Seber and Wild 1989, Nonlinear Regression, ch. 6"
_ARCHARD = "Archard 1953, J. Appl. Phys. 24, 981-988"
_FIT = "least squares of this measurement"
_FLANK = ("profile", "face")

_TABLE: dict[str, tuple[tuple[str, ...], str, str, str]] = {
    # name: dims, units, long name, source
    "deviation": (_FLANK, "um", "deviation along the normal, positive for material in excess", _ISO_1328),
    "wear_depth": (_FLANK, "um", "measured wear depth along the normal", _ARCHARD),
    "predicted": (_FLANK, "um", "predicted wear depth along the normal", _ARCHARD),
    "difference": (_FLANK, "um", "predicted minus measured wear depth", _ARCHARD),
    "flank_profile": (_FLANK, "mm", "profile coordinate, from root to tip", _ISO_1122),
    "flank_face": (_FLANK, "mm", "face coordinate", _ISO_1122),
    "flank_height": (_FLANK, "mm", "height above the pitch surface", _ISO_1122),
    "flank_radius": (_FLANK, "mm", "radius about the body's own axis", _ISO_1122),
    "inside": (_FLANK, "1", "whether the point lies on the nominal flank and counts", _FIT),
    "rotation": ((), "arcsec", "datum: rotation about the body's axis, its own z", _FIT),
    "axial": ((), "mm", "datum: shift along the body's axis, its own z", _FIT),
    "radial": ((), "mm", "datum: shift from the axis towards the flank", _FIT),
    "tangential": ((), "mm", "datum: shift across axis and radius", _FIT),
    "tilt_radial": ((), "arcsec", "datum: tilt about the radius", _FIT),
    "tilt_tangential": ((), "arcsec", "datum: tilt about the tangential direction", _FIT),
    "residual_rms": ((), "um", "root mean square residual", _FIT),
    "correlation_share": ((), "1", "share of the residuals that is correlated with its neighbours'", _SEBER),
    "correlation_length_profile": ((), "mm", "correlation length of the residuals along the profile", _SEBER),
    "correlation_length_face": ((), "mm", "correlation length of the residuals along the face", _SEBER),
    "points": ((), "1", "points that count", _FIT),
    "weight": (_FLANK, "1", "weight in the fit of the datum", _FIT),
    "difference_max": ((), "um", "greatest difference of predicted and measured wear", _FIT),
    "difference_rms": ((), "um", "root mean square difference of predicted and measured wear", _FIT),
    "correlation": ((), "1", "correlation of predicted and measured wear", _FIT),
    "scale": ((), "1", "measured wear over predicted wear, by least squares", _FIT),
}


def labelled(values: Mapping[str, object], attrs: Mapping[str, str], title: str) -> xr.Dataset:
    """Dataset of quantities of this table; ``<name>_uncertainty`` is the standard uncertainty of ``<name>``.

    Raises
    ------
    SemiwearError
        For a value that is not finite.
    """
    entries: dict[str, xr.Variable] = {}
    for name, value in values.items():
        quantity = name.removesuffix("_uncertainty")
        dims, units, text, source = _TABLE[quantity]
        array = np.asarray(value, dtype=np.int8 if name == "inside" else float)
        if not np.all(np.isfinite(array)):
            raise SemiwearError(f"{name}: not finite")
        if quantity != name:
            text = f"standard uncertainty of: {text}"
        entries[name] = xr.Variable(dims, array, {"units": units, "long_name": text, "references": source})
    sizes = next((entry.sizes for entry in entries.values() if entry.dims == _FLANK), {})
    coords = {str(dim): np.arange(size) for dim, size in sizes.items()}
    return xr.Dataset(entries, coords, {"title": title, **attrs})
