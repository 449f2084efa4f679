"""Corrections of the prism's tooth compliance on contact lines: free ends, and the wheel under an inclined tooth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.cubics import cubic_weights
from semiwear.compliance.inclined_wheel import OFFSETS, POLYNOMIALS, RingInfluence, elements_along, ring_influence
from semiwear.compliance.pitch_chain import DEFLECTION_OFFSETS, STRESS_OFFSETS
from semiwear.compliance.polynomials import along_width
from semiwear.compliance.root import add_later
from semiwear.compliance.section_outline import load_heights
from semiwear.compliance.strained_root import strained_root
from semiwear.compliance.tooth_ends import EndEffect, depth_of_ground
from semiwear.compliance.tooth_stretch import HEIGHTS, ORDERS
from semiwear.geometry.inclined_foot import InclinedFoot
from semiwear.geometry.section import ToothSection
from semiwear.kept_on_disk import kept_on_disk

_ASIDE = 3  # lowest orders of a load that act where its foot is: two to four differ by 0.5 % of the deflection


@dataclass(frozen=True)
class WheelInfluence:
    """Influence of loads on an inclined tooth through its wheel, which replaces the prism's ring.

    Attributes
    ----------
    foot : InclinedFoot
    wheel, virtual : RingInfluence
        The wheel, and the virtual spur gear's ring.
    fillet_share, factor : (F,) arrays
        Stress of the root for a unit stress of the wheel's surface, see `strained_root`.
    """

    foot: InclinedFoot
    wheel: RingInfluence
    virtual: RingInfluence
    fillet_share: FloatArray
    factor: FloatArray


@kept_on_disk
def wheel_influence(
    foot: InclinedFoot, section: ToothSection, *, youngs_modulus: float, poissons_ratio: float
) -> WheelInfluence:
    """Influence through the wheel under an inclined tooth, and through the ring that it replaces.

    Parameters
    ----------
    foot : InclinedFoot
    section : ToothSection
        Normal to the tooth [mm].
    youngs_modulus : float [MPa]
    poissons_ratio : float
    """
    elements, ground = elements_along(foot.wheel), depth_of_ground(section)
    wheel, virtual = (
        ring_influence(ring, youngs_modulus, poissons_ratio, elements, ground) for ring in (foot.wheel, foot.virtual)
    )
    # the prism has no influence at these offsets to be replaced
    virtual.compliance[np.abs(OFFSETS) > max(DEFLECTION_OFFSETS)] = 0.0
    virtual.stress[np.abs(OFFSETS) > max(STRESS_OFFSETS)] = 0.0
    # as the prism's, which has the length of the tooth on the reference cylinder
    virtual = virtual._replace(compliance=foot.crowding * virtual.compliance)
    share, factor = strained_root(section, poissons_ratio=poissons_ratio)
    return WheelInfluence(foot, wheel, virtual, share, factor)


@dataclass(frozen=True)
class _Form:
    """A quadratic form of loads: rows (roll, face, q) and their derivative by the observer's profile.

    The table (offsets, q, q) has the compliance for every tooth offset, or only for offset 0.
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
class BeyondOnLines:
    """The influence on contact lines.

    Attributes
    ----------
    forms : tuple
        Quadratic forms to be added to the compliance.
    ends : EndEffect
    along : (roll, face) array
        Coordinates along the axis from the middle of the body, over its width.
    width : float [mm]
    wheel : _StrainedWheel, optional
        Of an inclined tooth.
    """

    forms: tuple[_Form, ...]
    ends: EndEffect
    along: FloatArray
    width: float
    wheel: _StrainedWheel | None = None

    @classmethod
    def of(
        cls,
        ends: EndEffect,
        width: float,
        along: FloatArray,
        height: tuple[FloatArray, FloatArray],
        wheel: WheelInfluence | None = None,
        radius: tuple[FloatArray, FloatArray, FloatArray] | None = None,
    ) -> BeyondOnLines:
        """Prepare for contact lines.

        Parameters
        ----------
        ends : EndEffect
        width : float [mm]
            Of the body along its axis.
        along : (roll, face) array [mm]
            Places along the axis, from the middle of the body.
        height : two (roll, face) arrays [1], [1/mm]
            Of the places as shares of the flank, and its derivative by the driven flank's profile coordinate.
        wheel : WheelInfluence, optional
            Of an inclined tooth.
        radius : two (roll, face) arrays and one (H,) [mm], [1], [mm], optional
            Of the places about the axis, and its derivative; that of the load heights. For a wheel.
        """
        share = along / width
        weights, slopes = cubic_weights(height[0], load_heights(HEIGHTS))
        forms = [_form(along_width(share, ORDERS), weights, slopes * height[1][..., None], ends.deflection[None])]
        if wheel is None or radius is None:
            return cls(tuple(forms), ends, share, width)
        foot = wheel.foot
        on_wheel, on_virtual = (
            _spread(share, aside(radius[0]) / width) for aside in (foot.section_aside, foot.prism_aside)
        )
        forms.append(_ring_form(wheel.wheel.compliance, on_wheel, foot.on_wheel, radius))
        forms.append(_ring_form(-wheel.virtual.compliance, on_virtual, foot.on_virtual, radius))
        return cls(tuple(forms), ends, share, width, _StrainedWheel.of(wheel, radius[2]))

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

    def at_root(self, at: FloatArray, fillet: FloatArray) -> BeyondAtRoot:
        """Additional tangential stress: free ends on the loaded tooth, and the wheel of an inclined tooth on all.

        Parameters
        ----------
        at : (stations,) array [mm]
            Observers along the axis, from the middle of the body.
        fillet : (F,) array
            Points of the fillet as fractions of its length from the end of the flank.
        """
        ends, share = self.ends, at / self.width
        between = make_interp_spline(ends.fillet_share, np.eye(ends.fillet_share.size), k=3)(fillet)
        by_ends = np.einsum("zp,pgl,fg->zfl", along_width(share, ORDERS), ends.stress, between, optimize=True)
        wheel = None if self.wheel is None else self.wheel.at_root(self.along, share, fillet)
        return BeyondAtRoot(along_width(self.along, ORDERS), np.asarray(by_ends), wheel)


@dataclass(frozen=True)
class BeyondAtRoot:
    """Stress at points of the root, by loads on the contact lines.

    Attributes
    ----------
    spread : (roll, face, orders) array
        Of the loads along the axis.
    by_ends : (stations, F, loads) array [MPa/N]
        Additional stress due to free ends, by loads distributed along the axis and over the load heights.
    wheel : _WheelAtRoot, optional
    """

    spread: FloatArray
    by_ends: FloatArray
    wheel: _WheelAtRoot | None = None

    def stress(self, loads: FloatArray, per_tooth: int) -> FloatArray:
        """Stress [MPa], (roll, stations, F).

        Parameters
        ----------
        loads : (roll, face, places) array [N]
            Forces at load heights, spaced as `load_heights`.
        per_tooth : int
            Rolls from a tooth to the next towards where the load pushes; negative where those come earlier.
        """
        fewer, _ = cubic_weights(load_heights(loads.shape[2]), load_heights(HEIGHTS))
        force = (self.spread.transpose(0, 2, 1) @ loads @ fewer).reshape(len(loads), -1)
        stress = (force @ self.by_ends.reshape(-1, force.shape[1]).T).reshape(-1, *self.by_ends.shape[:2])
        return stress if self.wheel is None else stress + self.wheel.stress(loads, per_tooth)


@dataclass(frozen=True)
class _StrainedWheel:
    """Root stress by the strain of the wheel under inclined teeth, less that of the prism's ring.

    Attributes
    ----------
    table : (9, P, P, H) array [MPa/N]
        For each of `OFFSETS`: stress of the surface, spread along the axis, by loads at the load heights.
    fillet_share, factor : (F,) arrays
        See `WheelInfluence`.
    """

    table: FloatArray
    fillet_share: FloatArray
    factor: FloatArray

    @classmethod
    def of(cls, wheel: WheelInfluence, radius: FloatArray) -> _StrainedWheel:
        """By loads at the radii of the load heights [mm]."""
        parts = [
            np.einsum("oqpc,hc->oqph", ring.stress.reshape(*ring.stress.shape[:2], POLYNOMIALS, -1), load(radius))
            for ring, load in ((wheel.wheel, wheel.foot.on_wheel), (wheel.virtual, wheel.foot.on_virtual))
        ]
        return cls(parts[0] - parts[1], wheel.fillet_share, wheel.factor)

    def at_root(self, along: FloatArray, at: FloatArray, fillet: FloatArray) -> _WheelAtRoot:
        """As `BeyondOnLines.at_root`, for loads and observers at shares of the width."""
        observed = np.einsum("zq,oqph->ozph", along_width(at, POLYNOMIALS), self.table)
        factor = make_interp_spline(self.fillet_share, self.factor, k=3)(fillet)
        return _WheelAtRoot(along_width(along, POLYNOMIALS), observed, factor)


@dataclass(frozen=True)
class _WheelAtRoot:
    """Root stress by the strain of the wheel, at points of the root.

    Attributes
    ----------
    spread : (roll, face, P) array
        Of the loads along the axis.
    table : (9, stations, P, H) array [MPa/N]
        For each of `OFFSETS`: stress of the surface by loads at the load heights.
    factor : (F,) array
        From the stress of the surface to that at points of the fillet.
    """

    spread: FloatArray
    table: FloatArray
    factor: FloatArray

    def stress(self, loads: FloatArray, per_tooth: int) -> FloatArray:
        """As `BeyondAtRoot.stress`."""
        force = np.einsum("kfp,kfh->kph", self.spread, loads, optimize=True)
        seen = np.einsum("ozph,kph->okz", self.table, force, optimize=True)
        stress = np.zeros(seen.shape[1:])
        for teeth, part in zip(OFFSETS, seen, strict=True):
            # the loaded tooth is at the roll of the observed one less this tooth offset
            add_later(stress, part, int(teeth) * per_tooth)
        return np.asarray(stress[:, :, None] * self.factor)


def _spread(share: FloatArray, aside: FloatArray) -> FloatArray:
    """Spread along the width of feet that are aside of their loads, (roll, face, P).

    The lowest orders make force and moment of a foot's load; higher ones would be extrapolated beyond the ends.
    """
    spread = along_width(share, POLYNOMIALS)
    spread[..., :_ASIDE] = along_width(share + aside, _ASIDE)
    return spread


def _ring_form(
    table: FloatArray,
    spread: FloatArray,
    load: Callable[[FloatArray], FloatArray],
    radius: tuple[FloatArray, FloatArray, FloatArray],
) -> _Form:
    at, slope, at_heights = radius
    step = 1e-4 * float(np.mean(at_heights))  # of the tooth, not of these lines: a place has the same form on others
    change = (load(at + step) - load(at - step)) / (2.0 * step) * slope[..., None]
    return _form(spread, load(at), change, table)


def _form(shares: FloatArray, value: FloatArray, slope: FloatArray, table: FloatArray) -> _Form:
    rows, slopes = (
        (shares[..., None] * part[..., None, :]).reshape(*shares.shape[:2], -1) for part in (value, slope)
    )
    return _Form(rows, slopes, table)
