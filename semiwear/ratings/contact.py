"""Input of the failure modes: local quantities of the loaded contact in the contact lines and on both flanks."""

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
    """Nodes of both flanks at which safeties are given.

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
        """The nodes of the wear depths."""
        face, pair = teeth.grid.face, teeth.pair
        profile = np.stack([teeth.driving_profile, teeth.grid.profile])
        height = np.stack([pair.flank_place(body, face[:, None], profile[body])[0] for body in range(len(BODIES))])
        return cls(profile, height, face, np.array([pair.driving_meshes, 1.0]))


@dataclass(frozen=True, eq=False)
class RatedContact:
    """Contact over a mesh cycle on worn flanks, under one load of the spectrum.

    Arrays over (roll, face) hold every slice of the contact lines at every roll position.

    Attributes
    ----------
    teeth : LoadedTeeth
    state : LoadedState
    share : float
        Fraction of the meshes under this load; 1 without a spectrum.
    flanks : RatedFlanks
    speeds_of : callable
        Gives the surface velocities; called only if a mode needs them.
    known_pressures : SlicePressures or None
    known_root_stress : (roll, body) array [MPa] or None
        Already computed values of this contact, if there are any.
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
        """Greatest pressures: `inner` is 0 where a slice bears no load, and at edges, which are not rated."""
        return self.teeth.pressures(self.state) if self.known_pressures is None else self.known_pressures

    @property
    def rated(self) -> BoolArray:
        """Slices that bear load and do not lie at an edge, (roll, face)."""
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
        """Contact points of the worn flanks: profile coordinate on each body's own flank [mm], (body, roll, face)."""
        driven = np.where(self.rated, self.pressures.place, self.state.coarse.profile)
        return np.stack([self.teeth.lines.on_driving(driven), driven])

    def on_flanks(
        self, values: FloatArray, bearing: BoolArray | None = None, worst: np.ufunc = np.fmax
    ) -> FloatArray:
        """Values at the nodes of both flanks while the contact passes, from values in the contact lines.

        Linear between roll positions; the node next to a roll position also gets the value of that position, so that
        no extreme is lost between nodes. NaN where no contact passes. Slices touch the driving flank between its
        stations: there values are linear between slices, and the worst value of each contact line goes to the
        nearest station.

        Parameters
        ----------
        values : array that broadcasts to (body, roll, face)
        bearing : (roll, face) bool array, optional
            Slices that are used; default `rated`.
        worst : ufunc
            Choice among several values at a node: `numpy.fmax` for stresses, `numpy.fmin` for safeties.

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
        """Values at the stations of the driving flank from those of rated slices, and which stations have one."""
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
    """Loaded contact at one wear step, input of the failure modes.

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
