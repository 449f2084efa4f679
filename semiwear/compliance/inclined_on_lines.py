"""What an inclined tooth has beyond its prism, on contact lines: its wheel and its oblique ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from semiwear.compliance.inclined_wheel import OFFSETS, along_axis, elements_along, ring_compliance
from semiwear.compliance.pitch_chain import DEFLECTION_OFFSETS
from semiwear.compliance.section_outline import load_heights
from semiwear.compliance.tooth import cubic_weights
from semiwear.compliance.tooth_ends import HEIGHTS, EndEffect, end_effect
from semiwear.geometry.inclined_foot import InclinedFoot
from semiwear.geometry.section import ToothSection

__all__ = ["InclinedInfluence", "InclinedOnLines", "inclined_influence"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class InclinedInfluence:
    """Influence of loads on an inclined tooth, less that of its prism.

    Attributes
    ----------
    foot : InclinedFoot
    wheel, virtual : (9, 4 P, 4 P) arrays
        See `ring_compliance`: the wheel is put in the place of the virtual spur gear's ring.
    ends : EndEffect
    """

    foot: InclinedFoot
    wheel: FloatArray
    virtual: FloatArray
    ends: EndEffect


def inclined_influence(
    foot: InclinedFoot, section: ToothSection, *, youngs_modulus: float, poissons_ratio: float, name: str
) -> InclinedInfluence:
    """Work out the influence of loads on an inclined tooth, less that of its prism.

    Parameters
    ----------
    foot : InclinedFoot
    section : ToothSection
        Normal to the tooth.
    youngs_modulus : float [MPa]
    poissons_ratio : float
    name : str
        What error messages call the section.
    """
    elements = elements_along(foot.wheel)
    virtual = ring_compliance(foot.virtual, youngs_modulus, poissons_ratio, elements)
    virtual[np.abs(OFFSETS) > max(DEFLECTION_OFFSETS)] = 0.0  # the prism has nothing there to be exchanged
    return InclinedInfluence(
        foot=foot,
        wheel=ring_compliance(foot.wheel, youngs_modulus, poissons_ratio, elements),
        virtual=virtual,
        ends=end_effect(
            section,
            width=foot.width,
            slant=foot.slant,
            module=foot.tooth.normal_module,
            youngs_modulus=youngs_modulus,
            poissons_ratio=poissons_ratio,
            name=name,
        ),
    )


@dataclass(frozen=True)
class _Form:
    """A quadratic form of loads at stations: rows (roll, face, q) and their change with the observer's profile.

    The table (offsets, q, q) has the compliance for every number of teeth between, or only for none.
    """

    rows: FloatArray
    slopes: FloatArray
    table: FloatArray

    def between(self, teeth: int) -> FloatArray | None:
        if len(self.table) == 1:
            return self.table[0] if teeth == 0 else None
        index = int(np.searchsorted(OFFSETS, teeth))
        return self.table[index] if index < OFFSETS.size and OFFSETS[index] == teeth else None


@dataclass(frozen=True)
class InclinedOnLines:
    """The influence on contact lines.

    Attributes
    ----------
    forms : tuple
        Quadratic forms to be added to the compliance.
    ends : EndEffect
    along : (roll, face) array [mm]
        Places along the axis, from the middle of the body.
    """

    forms: tuple[_Form, ...]
    ends: EndEffect
    along: FloatArray

    @classmethod
    def of(
        cls,
        influence: InclinedInfluence,
        along: FloatArray,
        radius: tuple[FloatArray, FloatArray],
        height: tuple[FloatArray, FloatArray],
    ) -> InclinedOnLines:
        """Prepare for contact lines.

        Parameters
        ----------
        influence : InclinedInfluence
        along : (roll, face) array [mm]
            Places along the axis, from the middle of the body.
        radius : two (roll, face) arrays [mm], [1]
            Of the places about the axis, and its derivative by the driven flank's profile coordinate.
        height : two (roll, face) arrays [1], [1/mm]
            Of the places as shares of the flank, and its derivative.
        """
        foot, ends = influence.foot, influence.ends
        spread = along_axis(along / foot.width)
        weights, slopes = cubic_weights(height[0], load_heights(HEIGHTS))
        forms = (
            _ring_form(influence.wheel, spread, foot.on_wheel, radius),
            _ring_form(-influence.virtual, spread, foot.on_virtual, radius),
            _form(_shares(ends.stations, along), weights, slopes * height[1][..., None], ends.deflection[None]),
        )
        return cls(forms, ends, along)

    def add_compliance(
        self, rolls: IntArray, faces: IntArray, teeth: IntArray, matrix: FloatArray, slope: FloatArray
    ) -> None:
        """Add the compliance [mm/N] between contact points, and its derivative by the observer's profile.

        Parameters
        ----------
        rolls, faces : (n,) int arrays
            Indices of the contact points.
        teeth : (n,) int array
            The tooth of each point, counted towards where the load pushes; points sorted by tooth either way.
        matrix, slope : (n, n) arrays, changed
        """
        spans = {int(tooth): np.flatnonzero(teeth == tooth) for tooth in np.unique(teeth)}
        for form in self.forms:
            rows, slopes = form.rows[rolls, faces], form.slopes[rolls, faces]
            for observer, mine in spans.items():
                for loaded, theirs in spans.items():
                    table = form.between(observer - loaded)
                    if table is None:
                        continue
                    moved = table @ rows[theirs].T
                    block = slice(mine[0], mine[-1] + 1), slice(theirs[0], theirs[-1] + 1)
                    matrix[block] += rows[mine] @ moved
                    slope[block] += slopes[mine] @ moved

    def root_stress(self, loads: FloatArray, at: FloatArray, fillet: FloatArray) -> FloatArray:
        """Tangential stress that oblique ends add on the loaded tooth itself.

        Parameters
        ----------
        loads : (roll, face, places) array [N]
            Forces at load heights, spaced as `load_heights`.
        at : (stations,) array [mm]
            Observers along the axis, from the middle of the body.
        fillet : (F,) array
            Points of the fillet as shares of its length from the end of the flank.

        Returns
        -------
        (roll, stations, F) array [MPa]
        """
        ends = self.ends
        on_stations = _shares(ends.stations, self.along)
        fewer, _ = cubic_weights(load_heights(loads.shape[2]), load_heights(HEIGHTS))
        force = np.einsum("kfs,kfh,hg->ksg", on_stations, loads, fewer, optimize=True).reshape(len(loads), -1)
        between = make_interp_spline(ends.fillet_share, np.eye(ends.fillet_share.size), k=3)(fillet)
        table = np.einsum("zs,sgl,fg->zfl", _shares(ends.stations, at), ends.stress, between, optimize=True)
        return np.einsum("zfl,kl->kzf", table, force, optimize=True)


def _ring_form(
    table: FloatArray,
    spread: FloatArray,
    load: Callable[[FloatArray], FloatArray],
    radius: tuple[FloatArray, FloatArray],
) -> _Form:
    step = 1e-4 * float(np.mean(radius[0]))
    change = (load(radius[0] + step) - load(radius[0] - step)) / (2.0 * step) * radius[1][..., None]
    return _form(spread, load(radius[0]), change, table)


def _form(shares: FloatArray, value: FloatArray, slope: FloatArray, table: FloatArray) -> _Form:
    rows, slopes = (
        (shares[..., None] * part[..., None, :]).reshape(*shares.shape[:2], -1) for part in (value, slope)
    )
    return _Form(rows, slopes, table)


def _shares(stations: FloatArray, along: FloatArray) -> FloatArray:
    """Shares (..., S) of the two stations about each place; a place beyond the ends counts as an end."""
    return np.stack([np.interp(along, stations, unit) for unit in np.eye(stations.size)], axis=-1)
