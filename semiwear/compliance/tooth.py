"""Compliance and root stress of the teeth of two bodies along their contact lines.

Each body is a finite prism (`prism.py`) with one or several sections along its width. A load at height h and
width coordinate s contributes cos(n pi s/L) times the prism's small matrices, interpolated to h by local cubics:
a low-rank product. Where the section changes along the width, the solutions with the section of the load and with
that of the observer are averaged, which keeps the compliance symmetric. The remaining effect of a tapered tooth
comes from `taper`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.cubics import cubic_weights
from semiwear.compliance.local_weights import LocalWeights, between_points, seen_by_points
from semiwear.compliance.prism import PrismSection
from semiwear.compliance.root import ROOT_FROM, ROOT_STATIONS, at_root, greatest_along_root, loads_by_height
from semiwear.compliance.section_outline import load_heights
from semiwear.compliance.taper import Taper


@dataclass(frozen=True)
class ToothBody:
    """A toothed body as prisms.

    Attributes
    ----------
    start, width : float [mm]
        Face coordinate of the lower end, and length of the tooth.
    faces : (B,) array [mm]
        Face coordinates of the sections, growing.
    sections : tuple of B PrismSection
    ahead : int
        +1 when the next pair to have entered (roll + 1) is the neighbour on the loaded side of this body's
        tooth, -1 when it is the one behind.
    youngs_modulus [MPa], poissons_ratio [1] : float
    taper : Taper, optional
        Correction of a tapered tooth; its sections' prisms are then residual ones.
    """

    start: float
    width: float
    faces: FloatArray
    sections: tuple[PrismSection, ...]
    ahead: int
    youngs_modulus: float
    poissons_ratio: float
    taper: Taper | None = None

    @property
    def stations(self) -> FloatArray:
        """Face coordinates at which root stress is read [mm]."""
        return self.start + self.width * (np.arange(ROOT_STATIONS) + 0.5) / ROOT_STATIONS

    def heights(self, places: LinePlaces) -> tuple[FloatArray, FloatArray]:
        """Height of contact points as a share of the flank there, and its derivative by the driven profile [1/mm]."""
        section = _section_weights(self.faces, places.face)
        # heights run from the end of the fillet to the tip of the local section
        root, tip = (section @ np.array([s.load_profile[end] for s in self.sections]) for end in (0, -1))
        return (places.profile - root) / (tip - root), places.slope / (tip - root)


@dataclass(frozen=True)
class LinePlaces:
    """Position of contact lines on one body: (roll, face) arrays.

    Attributes
    ----------
    profile : array [mm]
        Profile coordinate on this body.
    slope : array
        Its derivative by the driven flank's profile coordinate.
    face : array [mm]
        Face coordinate on this body.
    """

    profile: FloatArray
    slope: FloatArray
    face: FloatArray


def _section_weights(faces: FloatArray, at: FloatArray) -> FloatArray:
    """Blending weights of the sections at face coordinates, local cubics: (..., B) array.

    Linear interpolation would overestimate the compliance, which is a convex function of the face coordinate.
    """
    return cubic_weights(at, faces)[0]


class BeyondPrism(Protocol):
    """Corrections of the compliance and root stress of a tooth's prism."""

    def add_compliance(
        self, rolls: IntArray, faces: IntArray, teeth: IntArray, matrix: FloatArray, slope: FloatArray
    ) -> None:
        """Add to the compliance between contact points; teeth are counted in the direction of the load."""

    def at_root(self, at: FloatArray, fillet: FloatArray) -> BeyondRoot:
        """Stress at points of the root, prepared for any loads.

        `at` counts from the middle of the body [mm], `fillet` is a share of the fillet's length.
        """


class BeyondRoot(Protocol):
    """Stress at points of the root in addition to that of the prism."""

    def stress(self, loads: FloatArray, per_tooth: int) -> FloatArray:
        """Stress of the fillet [MPa], (roll, station, fillet point), by forces at load heights.

        `per_tooth` is the number of rolls from a tooth to the next in the direction of the load.
        """


@dataclass(frozen=True)
class BodyOnLines:
    """Compliance of one body's prisms, prepared for the contact lines of all roll positions.

    Attributes
    ----------
    body : ToothBody
    place, place_slope : (roll, face) arrays
        Height of each contact point as a share of the flank there, and its derivative by the driven profile.
    height : (roll, face, H) array
        Weights of the load heights at each contact point.
    section : (roll, face, B) array
        Weights of the sections.
    cosine : (roll, face, N) array
        cos(n pi s/L).
    depth : (roll, face) array [mm]
        Distance from the flank to the mid-surface, at which the prism's deflection is taken.
    deflection : (5, B, H, N H) array
        Prism matrices [tooth offset, section, observer, harmonic and load], mm/N.
    stress : (B, N, H, 3 F) array
        Fillet stress [section, harmonic, load, tooth offset and fillet point], MPa/N.
    beyond : BeyondPrism or None
        Corrections for free ends, and for the wheel of an inclined tooth.
    splines : (roll, face, S) array, optional
        Values of the splines of a tapered tooth.
    local_heights, local_sections, local_splines : LocalWeights
        The same weights, of points (roll face,), on their few non-zero nodes.
    """

    body: ToothBody
    place: FloatArray
    place_slope: FloatArray
    height: FloatArray
    section: FloatArray
    cosine: FloatArray
    depth: FloatArray
    deflection: FloatArray
    stress: FloatArray
    local_heights: LocalWeights
    local_sections: LocalWeights
    beyond: BeyondPrism | None = None
    splines: FloatArray | None = None
    local_splines: LocalWeights | None = None

    @classmethod
    def of(
        cls, body: ToothBody, places: LinePlaces, beyond: BeyondPrism | None = None, along: FloatArray | None = None
    ) -> BodyOnLines:
        """Prepare a body for contact lines at `places`.

        `along` has the face coordinates (roll, face) [mm] at which their loads act on the prism, if other than these.
        """
        section = _section_weights(body.faces, places.face)
        count = body.sections[0].load_profile.size
        place, place_slope = body.heights(places)
        height, slope = cubic_weights(place, load_heights(count))
        harmonics = body.sections[0].deflection.shape[0]
        angle = np.pi * ((places.face if along is None else along) - body.start) / body.width
        depth = np.einsum("kib,bh,kih->ki", section, np.stack([s.depth for s in body.sections]), height)
        # the series resolves no length below half its last wave, nor may the part subtracted from the half-space
        depth = np.maximum(depth, body.width / max(body.sections[0].deflection.shape[0] - 1, 1))
        deflection = np.stack([s.deflection for s in body.sections])  # (B, N, 5, obs, load)
        stress = np.stack([at_root(s, s.stress) for s in body.sections])  # (B, N, 3, F, load)
        slope = slope * place_slope[..., None]
        cosine = np.cos(angle[..., None] * np.arange(harmonics))
        splines = body.taper.splines(places.face) if body.taper is not None else None
        return cls(
            body=body,
            splines=splines,
            local_heights=LocalWeights.of(height, slope),
            local_sections=LocalWeights.of(section),
            local_splines=None if splines is None else LocalWeights.of(splines),
            place=place,
            place_slope=place_slope,
            height=height,
            section=section,
            cosine=cosine,
            depth=depth,
            deflection=np.ascontiguousarray(deflection.transpose(2, 0, 3, 1, 4)).reshape(
                deflection.shape[2], len(body.sections), count, -1
            ),
            stress=np.ascontiguousarray(stress.transpose(0, 1, 4, 2, 3).reshape(*stress.shape[:2], count, -1)),
            beyond=beyond,
        )

    def add_compliance(
        self, rolls: IntArray, faces: IntArray, pairs: IntArray, matrix: FloatArray, slope: FloatArray
    ) -> None:
        """Add this body's compliance [mm/N] between contact points, and its derivative by the observer's profile.

        Parameters
        ----------
        rolls, faces : (n,) int arrays
            Indices of the contact points.
        pairs : (n,) int array
            Tooth pair of each point, 0 for the one that entered last; points sorted by it.
        matrix, slope : (n, n) arrays, changed
            Not yet symmetric: the caller averages with the transpose.
        """
        reach = (len(self.deflection) - 1) // 2
        points = rolls * self.place.shape[1] + faces
        heights, sections = self.local_heights.at(points), self.local_sections.at(points)
        cosine = self.cosine[rolls, faces]
        load = (cosine[:, :, None] * self.height[rolls, faces][:, None, :]).reshape(rolls.size, -1)
        teeth = np.unique(pairs)
        for observer in teeth:
            mine = np.flatnonzero(pairs == observer)
            own = heights.at(mine), sections.at(mine), cosine[mine]
            for loaded in teeth:
                offset = self.body.ahead * (int(observer) - int(loaded))
                if abs(offset) > reach:
                    continue
                theirs = np.flatnonzero(pairs == loaded)
                block = seen_by_points(self.deflection[reach + offset], *own) @ load[theirs].T
                if self.body.taper is not None and abs(offset) <= 1:
                    # the table is reciprocal: the deflection of tooth A by loads on B is the transpose of B's by A
                    table = self.body.taper.deflection[1 - offset]
                    assert self.splines is not None and self.local_splines is not None
                    block += between_points(
                        table, self.splines.shape[-1], self.local_heights, self.local_splines,
                        points[mine], points[theirs],
                    )  # fmt: skip
                matrix[mine[0] : mine[-1] + 1, theirs[0] : theirs[-1] + 1] += block[: mine.size]
                slope[mine[0] : mine[-1] + 1, theirs[0] : theirs[-1] + 1] += block[mine.size :]
        if self.beyond is not None:
            # `ahead` points to the loaded side, against the direction of the load
            self.beyond.add_compliance(rolls, faces, -self.body.ahead * pairs, matrix, slope)

    def root_stress(self, force: FloatArray, per_cycle: int, moved: FloatArray | None = None) -> FloatArray:
        """Greatest tensile tangential stress along the root of the body's tooth [MPa].

        Parameters
        ----------
        force : (roll, face) array [N]
            Forces of every slice; roll positions of all pairs, `per_cycle` of them to a mesh cycle. With `moved` also
            (roll, face, places): forces at several points across each line.
        per_cycle : int
            Number of roll positions to a base pitch.
        moved : array [mm], optional
            Distance of each force from the contact line, in the driven flank's profile coordinate; of the shape of
            `force`. On a worn flank the contact is beside the line: near the fillet a load bends the tooth
            less but stresses the root beside it, so that a millimetre matters. By default all act on the line.

        Returns
        -------
        (roll,) array
            For the tooth at each roll position, with the loads on its neighbours at the same instant.
        """
        tooth = self.body
        sections, harmonics, heights, width = self.stress.shape
        if moved is None:
            loads = force[..., None] * self.height
        else:
            loads = loads_by_height(force, moved, self.place, self.place_slope, load_heights(heights))
        loaded = np.flatnonzero(loads.any(axis=(1, 2)))
        # modal loads of each load's own section: (harmonic, roll, section and height)
        shares = self.section[loaded][..., None] * loads[loaded][:, :, None, :]
        modal = self.cosine[loaded].transpose(0, 2, 1) @ shares.reshape(*shares.shape[:2], -1)
        modal = np.ascontiguousarray(modal.transpose(1, 0, 2))
        # the mean of the stresses with the section of the load and with that of the observer
        stations, points = ROOT_STATIONS, width // 3
        table = self.stress.transpose(1, 0, 2, 3).reshape(harmonics, -1, width)  # (harmonic, section and height, ...)
        by_load = modal @ table
        seen = (self._waves_at_root @ by_load.reshape(harmonics, -1)).reshape(stations, loaded.size, 3, points)
        own = np.ascontiguousarray(seen.transpose(1, 2, 0, 3))
        if self._along.size > 0:
            if sections > 1:
                own *= 0.5
            self._add_by_height(loads[loaded], loaded, own.reshape(loaded.size, -1))
        stress = np.zeros((3, loads.shape[0], stations, points))
        stress[:, loaded] = own.transpose(1, 0, 2, 3)
        result = stress[1]
        if self._beyond_root is not None:
            result = result + self._beyond_root.stress(loads, -tooth.ahead * per_cycle)
        # a neighbour's load: the pair one roll ahead is the neighbour on the loaded side when `ahead` is +1,
        # and the observer is then its neighbour on the other side
        result[:-per_cycle] += stress[1 - tooth.ahead][per_cycle:]
        result[per_cycle:] += stress[1 + tooth.ahead][:-per_cycle]
        return greatest_along_root(result)

    @cached_property
    def _beyond_root(self) -> BeyondRoot | None:
        """Corrections of the stress at the stations and at points of the fillet."""
        if self.beyond is None:
            return None
        body = self.body
        points = np.linspace(ROOT_FROM, 1.0, self.stress.shape[-1] // 3)
        return self.beyond.at_root(body.stations - (body.start + 0.5 * body.width), points)

    @cached_property
    def _waves_at_root(self) -> FloatArray:
        """cos(n pi s/L) at the stations, (stations, N)."""
        share = (self.body.stations - self.body.start) / self.body.width
        return np.asarray(np.cos(np.pi * np.outer(share, np.arange(self.stress.shape[1]))))

    def _add_by_height(self, loads: FloatArray, rolls: IntArray, stress: FloatArray) -> None:
        """Add stress tabulated by height of loads (roll, face, H) at some rolls: (roll, offset station point)."""
        along = self._along[rolls].transpose(0, 2, 1) @ loads
        for spread, table in zip(np.ascontiguousarray(along.transpose(2, 0, 1)), self._root_by_height, strict=True):
            on = np.flatnonzero(spread.any(axis=1))  # a line covers few heights
            stress[on] += spread[on] @ table

    @cached_property
    def _along(self) -> FloatArray:
        """Basis along the axis for loads by height: waves where sections differ, splines where the tooth tapers."""
        parts = [self.cosine] if len(self.body.sections) > 1 else []
        parts += [] if self.splines is None else [self.splines]
        return np.concatenate([np.zeros((*self.place.shape, 0)), *parts], axis=-1)

    @cached_property
    def _root_by_height(self) -> FloatArray:
        """Stress at the root by loads of each height in the basis `_along`: (H, ..., offset station point)."""
        _, harmonics, heights, width = self.stress.shape
        parts = []
        if len(self.body.sections) > 1:
            # half of the stress by waves with the sections at the stations
            own = np.tensordot(_section_weights(self.body.faces, self.body.stations), self.stress, 1)
            table = 0.5 * self._waves_at_root[:, :, None, None] * own
            table = table.reshape(ROOT_STATIONS, harmonics, heights, 3, width // 3)
            parts.append(table.transpose(2, 1, 3, 0, 4).reshape(heights, harmonics, -1))
        if self.body.taper is not None:
            table = self.body.taper.stress.reshape(3, heights, -1, ROOT_STATIONS * width // 3)
            parts.append(table.transpose(1, 2, 0, 3).reshape(heights, -1, ROOT_STATIONS * width))
        return np.concatenate(parts, axis=1)


@dataclass(frozen=True)
class OfModulus:
    """A body that differs from another one in its Young's modulus alone: deflections are inverse to it.

    Attributes
    ----------
    reference : BodyOnLines
        The other body.
    youngs_modulus : float [MPa]
    """

    reference: BodyOnLines
    youngs_modulus: float

    @property
    def body(self) -> ToothBody:
        """The body; its sections are those of the other one."""
        return replace(self.reference.body, youngs_modulus=self.youngs_modulus)

    @property
    def depth(self) -> FloatArray:
        """As in `elastic_teeth.CompliantBody`: (roll, face) array [mm]."""
        return self.reference.depth

    def add_compliance(
        self, rolls: IntArray, faces: IntArray, pairs: IntArray, matrix: FloatArray, slope: FloatArray
    ) -> None:
        """As in `CompliantBody`."""
        part, change = np.zeros_like(matrix), np.zeros_like(slope)
        self.reference.add_compliance(rolls, faces, pairs, part, change)
        ratio = self.reference.body.youngs_modulus / self.youngs_modulus
        matrix += ratio * part
        slope += ratio * change

    def root_stress(self, force: FloatArray, per_cycle: int, moved: FloatArray | None = None) -> FloatArray:
        """As in `CompliantBody`: that of the other body, independent of the modulus."""
        return self.reference.root_stress(force, per_cycle, moved)
