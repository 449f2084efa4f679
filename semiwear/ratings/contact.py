"""Loaded contact as failure modes look at it: local quantities in the contact lines, and on both flanks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.line_conditions import line_conditions
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import SlicePressures
from semiwear.meshing.flank_grid import between_stations
from semiwear.meshing.flank_pair import BODIES, DRIVING
from semiwear.meshing.surface_speed import SurfaceSpeeds


@dataclass(frozen=True, eq=False)
class RatedFlanks:
    """Nodes of both flanks on which safeties are told.

    Attributes
    ----------
    profile, height : (body, face, node) arrays [mm]
        Profile coordinate on the body's own flank, growing from root to tip, and height above the pitch surface.
    face : (face,) array [mm]
    cycles : (body,) array
        Load cycles of a tooth in one mesh of a gear tooth.
    """

    profile: FloatArray
    height: FloatArray
    face: FloatArray
    cycles: FloatArray

    @classmethod
    def of(cls, teeth: LoadedTeeth) -> RatedFlanks:
        """The nodes on which wear is kept."""
        face, pair = teeth.grid.face, teeth.pair
        profile = np.stack([teeth.driving_profile, teeth.grid.profile])
        height = np.stack([pair.flank_place(body, face[:, None], profile[body])[0] for body in range(len(BODIES))])
        return cls(profile, height, face, np.array([pair.driving_meshes, 1.0]))


@dataclass(frozen=True, eq=False)
class RatedContact:
    """Contact over a mesh cycle on worn flanks, under one load of the spectrum.

    Arrays over (roll, face) tell of every slice of the contact lines at every roll position.

    Attributes
    ----------
    teeth : LoadedTeeth
    state : LoadedState
    share : float
        Of the meshes; 1 without a spectrum.
    flanks : RatedFlanks
    speeds_of : callable
        The motion of the surfaces, worked out when a mode asks for it.
    known_pressures : SlicePressures or None
    known_root_stress : (roll, body) array [MPa] or None
        What is known of this contact already.
    """

    teeth: LoadedTeeth
    state: LoadedState
    share: float
    flanks: RatedFlanks
    speeds_of: Callable[[LoadedTeeth], SurfaceSpeeds]
    known_pressures: SlicePressures | None = None
    known_root_stress: FloatArray | None = None

    @cached_property
    def pressures(self) -> SlicePressures:
        """Greatest pressures: `inner` is 0 where a slice bears nothing or lies at an edge, which is not rated."""
        return self.teeth.pressures(self.state) if self.known_pressures is None else self.known_pressures

    @property
    def rated(self) -> BoolArray:
        """Slices that bear away from edges, (roll, face)."""
        return self.pressures.inner > 0.0

    @cached_property
    def speeds(self) -> SurfaceSpeeds:
        """Velocities in the contact lines; the scene must give the pinion's speed."""
        return self.speeds_of(self.teeth)

    @cached_property
    def conditions(self) -> ContactConditions:
        """Load, Hertz half-width, curvature, pressure, rolling and sliding velocities of every slice."""
        return line_conditions(self.teeth.problem, self.state.loads, self.state.coarse, self.speeds)

    @cached_property
    def root_stress(self) -> FloatArray:
        """Greatest root stress of each body's tooth at every roll position [MPa], (body, roll)."""
        known = self.known_root_stress
        return self.teeth.root_stress(self.state).T if known is None else known.T

    @cached_property
    def places(self) -> FloatArray:
        """Where worn flanks touch: profile coordinate on each body's own flank [mm], (body, roll, face)."""
        driven = np.where(self.rated, self.pressures.place, self.state.coarse.profile)
        return np.stack([self.teeth.lines.on_driving(driven), driven])

    def on_flanks(
        self, values: FloatArray, bearing: BoolArray | None = None, worst: np.ufunc = np.fmax
    ) -> FloatArray:
        """Values in the contact lines as the points of both flanks feel them when the contact passes.

        Linear between roll positions, whose own values stand at the nodes next to them, so that no extreme is lost
        between two; NaN where no contact passes. Slices meet the driving flank beside its stations: there values
        are linear between slices, and the worst one of each contact line stands at the station next to it.

        Parameters
        ----------
        values : array that broadcasts to (body, roll, face)
        bearing : (roll, face) bool array, optional
            Slices that count; those that are `rated` where left out.
        worst : ufunc
            Which of several values at one node stands: `numpy.fmax` of stresses, `numpy.fmin` of safeties.

        Returns
        -------
        (body, face, node) array
        """
        profile, rated = self.flanks.profile, self.rated if bearing is None else bearing
        values = np.broadcast_to(values, (len(BODIES), *rated.shape))
        found = np.full(profile.shape, np.nan)
        for body in range(len(BODIES)):
            counts, places, known = rated, self.places[body], values[body]
            if body == DRIVING:
                known, counts = self._at_driving_stations(known, rated, worst)
                places = self.teeth.driving_stations.read(places)
            for i in np.flatnonzero(counts.any(axis=0)):
                on, nodes = counts[:, i], profile[body, i]
                place, own = places[on, i], known[on, i]
                order = np.argsort(place)
                passed = (nodes >= place[order[0]]) & (nodes <= place[order[-1]])
                found[body, i, passed] = np.interp(nodes[passed], place[order], own[order])
                middles = 0.5 * (nodes[1:] + nodes[:-1])
                worst.at(found[body, i], np.searchsorted(middles, place), own)
        return found

    def _at_driving_stations(
        self, values: FloatArray, rated: BoolArray, worst: np.ufunc
    ) -> tuple[FloatArray, BoolArray]:
        """Values in slices that count, at the stations of the driving flank, and which of these count."""
        stations = self.teeth.driving_stations
        found, counts = stations.read_within(values, rated), stations.within(rated)
        rolls = np.flatnonzero(rated.any(axis=1))
        extreme = worst.reduce(np.where(rated, values, np.nan)[rolls], axis=1)
        at = np.argmax(rated[rolls] & (values[rolls] == extreme[:, None]), axis=1)
        low, weight = between_stations(self.flanks.face, self.teeth.lines.driving_face[rolls, at])
        beside = rolls, low + (weight > 0.5)
        found[beside] = worst(np.where(counts[beside], found[beside], np.nan), extreme)
        counts[beside] = True
        return found, counts


@dataclass(frozen=True, eq=False)
class WornStep:
    """One wear step as failure modes see it.

    Attributes
    ----------
    meshes : float
        Engagements of one gear tooth so far.
    contacts : tuple of RatedContact
        Under every load of the spectrum.
    """

    meshes: float
    contacts: tuple[RatedContact, ...]

    @property
    def flanks(self) -> RatedFlanks:
        """Nodes of both flanks."""
        return self.contacts[0].flanks
