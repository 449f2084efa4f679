"""From states of the loaded, worn teeth to the plain arrays of a result.

Names and units of these arrays are defined in `semiwear.results.schema`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import SlicePressures
from semiwear.contact.patch_contact import subsurface_stress
from semiwear.contact.pressed_tips import relief_to_free, tip_load_share
from semiwear.effect_clock import EffectClock
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING, reference_lever
from semiwear.meshing.point_flank_pair import PointFlankMesh
from semiwear.results import Zone
from semiwear.wear.state import WearState
from semiwear.wear.swept_line import Sweep
from semiwear.wear.volume import map_volume

if TYPE_CHECKING:
    from semiwear.observers import Observer

Arrays = dict[str, np.ndarray]

_UM = 1e3  # micrometres in a millimetre
_DISTANCE = 0.25  # of the pitch band's width, half a half-width: across it a worn ridge's pressure falls by half
_SAME_PLACE = 1e-6  # of the distance to the next position: less is rounding


def coordinates(teeth: LoadedTeeth) -> Arrays:
    """Labels of the dims: roll and mesh positions, face stations, profile index."""
    return {
        "roll_position": teeth.rolls.roll,
        "mesh_position": np.sort(teeth.rolls.mesh_position),
        "face": teeth.grid.face,
        "profile": np.arange(teeth.grid.profile.shape[1]),
    }


def _greatest_below(border: FloatArray, value: FloatArray, place: FloatArray) -> float:
    """Greatest of (roll, face) values at places below a border, as far as the border itself.

    The result must not depend on how near a roll position lies to the border, beyond which the value may drop. So it
    is extrapolated from the last position below, with the median slope of all slices: extrapolation of a single
    slice would amplify its ripple. NaN if no value lies below.
    """
    loaded = value > 0.0
    below = loaded & (place < border)
    if not below.any():
        return np.nan
    best = float(np.max(value, where=below, initial=0.0))
    for order in (slice(None), slice(None, None, -1)):
        v, x, inside, counts = value[order], place[order], below[order], loaded[order]
        leaves = inside[:-2] & inside[1:-1] & counts[2:] & ~inside[2:]
        # two positions at one place, as on an edge, give no slope
        leaves &= np.abs(x[1:-1] - x[:-2]) > _SAME_PLACE * np.abs(x[2:] - x[1:-1])
        if leaves.any():
            slope = np.median((v[1:-1] - v[:-2])[leaves] / (x[1:-1] - x[:-2])[leaves])
            best = max(best, float(np.max(v[1:-1] + slope * (border - x[1:-1]), where=leaves, initial=0.0)))
    return best


@dataclass(frozen=True)
class _Zones:
    """Pitch band of a flank: profile coordinates of its two borders in each slice [mm]."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, teeth: LoadedTeeth) -> _Zones:
        pitch = teeth.pair.pitch_profile(teeth.grid.face)
        half = teeth.half_width / np.mean(teeth.lines.spacing, axis=0)
        return cls(pitch - half, pitch + half)

    @classmethod
    def of_driving(cls, teeth: LoadedTeeth) -> _Zones:
        """Pitch band of the driving flank: the part that meets the driven flank's band.

        Where a slice's path of contact does not cross the band, all of it is on one side.
        """
        own, lines = cls.of(teeth), teeth.lines
        inside, theirs = teeth.on_path, (lines.driving_face, lines.driving_profile)
        met = []  # slices out of contact take the values of their neighbours
        for i in np.flatnonzero(inside.any(axis=0)):
            on = np.flatnonzero(inside[:, i])
            order = on[np.argsort(lines.profile[on, i])]
            # higher on one flank is lower on the other
            at = (own.high[i], own.low[i])
            met.append([np.interp(at, lines.profile[order, i], on_driving[order, i]) for on_driving in theirs])
        found = []
        for face, border in np.moveaxis(np.array(met), 0, -1).swapaxes(0, 1):
            order = np.argsort(face)
            found.append(np.interp(teeth.grid.face, face[order], border[order]))
        return cls(*found)

    def of_profile(self, profile: FloatArray) -> IntArray:
        """Zone of profile coordinates; `profile` has the slices along its last axis."""
        return np.where(
            profile < self.low, int(Zone.ROOT), np.where(profile > self.high, int(Zone.ADDENDUM), int(Zone.PITCH))
        )

    def greatest_clear(self, pressure: SlicePressures) -> dict[Zone, float]:
        """Greatest pressure in each zone, at a distance from the band, near which it rises by a tenth in a roll step.

        NaN in a zone without pressures.
        """
        distance = _DISTANCE * (self.high - self.low)
        value, place = pressure.inner, pressure.place
        inside = (place >= self.low) & (place <= self.high) & (value > 0.0)
        return {
            Zone.ROOT: _greatest_below(self.low - distance, value, place),
            Zone.PITCH: float(np.max(value, where=inside, initial=0.0)) if inside.any() else np.nan,
            Zone.ADDENDUM: _greatest_below(-self.high - distance, value, -place),
        }

    def greatest(self, value: FloatArray, profile: FloatArray) -> dict[Zone, float]:
        """Greatest value in each zone along curves that cross it, read at the zone's borders as well.

        Parameters
        ----------
        value, profile : (along the curve, face) arrays
            Samples and their profile coordinates; linear between two.
        """
        zone = self.of_profile(profile)
        best = {z: float(np.max(value, where=zone == z, initial=0.0)) for z in Zone}
        for border, zones in ((self.low, (Zone.ROOT, Zone.PITCH)), (self.high, (Zone.PITCH, Zone.ADDENDUM))):
            a, b = profile[:-1] - border, profile[1:] - border
            crosses = a * b < 0.0
            fraction = np.where(crosses, a / np.where(crosses, a - b, 1.0), 0.0)
            there = value[:-1] + fraction * (value[1:] - value[:-1])
            at_border = float(np.max(there, where=crosses, initial=0.0))
            for z in zones:
                best[z] = max(best[z], at_border)
        return best


def _by_position(teeth: LoadedTeeth, values: FloatArray) -> FloatArray:
    """Values in the order of rising mesh position."""
    return values[np.argsort(teeth.rolls.mesh_position)]


def engagement(teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures, fresh: Sweep) -> Arrays:
    """Quantities of one wear state at every roll position.

    Speeds over the flanks are those of the fresh contact lines (`fresh_sweep`): wear moves a line by a fraction of
    its path, but makes its speed vary between roll positions.
    """
    lines, loads = teeth.lines, state.loads
    moment = np.sum(loads.force * lines.lever_arm, axis=1)
    total = moment.reshape(teeth.rolls.pairs, -1).sum(axis=0)
    greatest = np.argmax(pressure.inner, axis=1)
    rows = np.arange(greatest.size)
    # a line at an edge has no speed over the flank: contacts that an edge cuts off have no sliding distance
    width = np.where(pressure.inner[rows, greatest] > 0.0, 2.0 * loads.half_width[rows, greatest], 0.0)
    sliding = np.stack(
        [specific[rows, greatest] * width for specific in (fresh.driving_specific_sliding, fresh.specific_sliding)],
        axis=-1,
    )
    inner, edge = pressure.inner.max(axis=1), pressure.border.max(axis=1)
    on_edge = (inner <= 0.0) & (edge > 0.0)
    arrays = {
        "load_share": moment / np.tile(total, teeth.rolls.pairs),
        "contact_pressure_max": np.where(on_edge, edge, inner),
        "contact_pressure_on_edge": on_edge.astype(np.int8),
        "contact_pressure_max_edge": edge,
        "tip_load_share": tip_load_share(teeth, state),
        "line_load": teeth.problem.line_load(loads),
        "sliding_distance": np.where(on_edge[:, None], np.nan, sliding),
    }
    if teeth.problem.bodies:
        arrays["root_stress"] = teeth.root_stress(state)
    return arrays


def mesh_cycle(teeth: LoadedTeeth, state: LoadedState) -> Arrays:
    """Quantities of one wear state at every mesh position."""
    pairs = teeth.rolls.pairs
    # rotations of the bodies, as approaches at one lever arm
    lever = reference_lever(teeth.pair)
    least = (state.coarse.least * (lever / teeth.lines.lever_arm)).min(axis=1).reshape(pairs, -1).min(axis=0)
    loaded = np.any(state.loads.force > 0.0, axis=1).reshape(pairs, -1).sum(axis=0)
    scale = -teeth.pair.arcsec_per_mm
    return {
        "transmission_error_loaded": _by_position(teeth, scale * (lever * state.loads.rotation - teeth.zero)),
        "transmission_error_unloaded": _by_position(teeth, scale * (least - teeth.zero)),
        "pairs_in_contact": _by_position(teeth, loaded),
    }


def history(teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures, parts: Mapping[str, Arrays]) -> Arrays:
    """Quantities of one wear state, from its pressures, engagement and mesh cycle."""
    zones = _Zones.of(teeth)
    wear = zones.greatest(_UM * state.wear.T, teeth.grid.profile.T)
    stress = zones.greatest_clear(pressure)
    error = parts["mesh_cycle"]["transmission_error_loaded"]
    arrays: dict[str, float | np.ndarray] = {
        "wear_depth_max_root": wear[Zone.ROOT],
        "wear_depth_max_addendum": wear[Zone.ADDENDUM],
        "wear_depth_max_pitch": wear[Zone.PITCH],
        "load_share_max": parts["engagement"]["load_share"].max(),
        "contact_pressure_root": stress[Zone.ROOT],
        "contact_pressure_addendum": stress[Zone.ADDENDUM],
        "contact_pressure_pitch": stress[Zone.PITCH],
        "transmission_error_mean": error.mean(),
        "transmission_error_amplitude": np.ptp(error),
        "tip_relief_to_free": _UM * relief_to_free(teeth, state),
    }
    greatest = {DRIVING: 0.0, DRIVEN: _UM * float(state.wear.max())}
    if state.driving_wear is not None and teeth.driving is not None:
        greatest[DRIVING] = arrays["wear_depth_max_pinion"] = _UM * float(state.driving_wear.max())
        worn = _Zones.of_driving(teeth).greatest(_UM * state.driving_wear.T, teeth.driving.grid.profile.T)
        arrays |= {f"wear_depth_max_pinion_{zone.name.lower()}": worn[zone] for zone in Zone}
    arrays["wear_depth_max"] = np.array([greatest[body] for body in range(len(BODIES))])
    if "root_stress" in parts["engagement"]:
        arrays["root_stress_max"] = parts["engagement"]["root_stress"].max(axis=0)
    return {name: np.asarray(value) for name, value in arrays.items()}


def slices(teeth: LoadedTeeth) -> Arrays:
    """Lengths and lever arms from line loads to forces and moments, the same in all wear states."""
    return {"line_length": teeth.lines.length, "lever_arm": teeth.lines.lever_arm}


def subsurface(teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures, poissons_ratio: float) -> Arrays:
    """Stress below the driven flank where the pressure is greatest away from the borders; fidelity `patch` only."""
    if teeth.problem.cells is None:
        return {}
    roll, face = np.unravel_index(int(np.argmax(pressure.inner)), pressure.inner.shape)
    found = subsurface_stress(teeth.problem, state.loads, int(roll), int(face), poissons_ratio)
    return {
        "subsurface_stress_max": np.asarray(found.von_mises),
        "subsurface_stress_depth": np.asarray(found.von_mises_depth),
    }


def contact_patterns(teeth: LoadedTeeth, states: Sequence[LoadedState]) -> Arrays:
    """Greatest pressure at each point of the driven flank, (wear_step, profile, face); fidelity `patch` only."""
    cells = teeth.problem.cells
    if cells is None:
        return {}
    pressures = (cells.pressure(state.loads.cells) for state in states)
    return {"contact_pattern": np.stack([cells.greatest_on_flank(pressure).T for pressure in pressures])}


def observed(
    teeth: LoadedTeeth,
    state: LoadedState,
    pressure: SlicePressures,
    observers: Sequence[Observer],
    clock: EffectClock,
) -> tuple[Arrays, Arrays]:
    """Quantities of the observers at every roll position, and once for the state."""
    engagement: Arrays = {}
    history: Arrays = {}
    for observer in observers:
        with clock.measure(observer.effect):
            found = observer.engagement(teeth, state, pressure)
            engagement |= found
            history |= observer.history(teeth, found)
    return engagement, history


def residuals(state: LoadedState) -> Arrays:
    """Residuals of the equations of one wear state."""
    loads = state.loads
    return {
        "iterations": np.asarray(int(loads.iterations.max())),
        "load_balance_residual": np.asarray(loads.balance.max()),
        "complementarity_residual": np.asarray(loads.complementarity.max()),
        "edge_residual": np.asarray(state.edge_residual),
    }


def volumes(teeth: LoadedTeeth, state: WearState) -> Arrays:
    """Wear volumes of both bodies [mm^3], (body,), as in `semiwear.wear.volume`."""
    return {
        "wear_volume": map_volume(teeth, *state.worn),
        "wear_volume_on_edges": state.volume.on_edges,
    }


def volume_residual(teeth: LoadedTeeth, state: WearState) -> Arrays:
    """Volume on flanks and edges over that from forces and sliding, less 1; 0 for a body that does not wear."""
    driven, found = state.volume.driven, map_volume(teeth, *state.worn) + state.volume.on_edges
    ratio = np.divide(found, driven, out=np.ones_like(driven), where=driven > 0.0)
    return {"wear_volume_residual": ratio - 1.0}


def flank(teeth: LoadedTeeth, fresh: Sweep) -> Arrays:
    """Both flanks on their grids: places, zones, sliding of the fresh lines; (body, profile, face)."""
    pair, grid, lines = teeth.pair, teeth.grid, teeth.lines
    zones = {DRIVING: _Zones.of_driving(teeth), DRIVEN: _Zones.of(teeth)}
    inside, passed = teeth.on_path, teeth.driving_stations
    # specific sliding is positive on the addendum, where the body's own line runs faster than the other's (ISO 21771)
    sign = -np.sign(fresh.sliding[..., 0])
    driving = passed.read_within(-sign * fresh.driving_specific_sliding, inside)
    parts = {
        DRIVING: (teeth.driving_profile, passed.read(lines.driving_profile), driving, passed.within(inside)),
        DRIVEN: (grid.profile, lines.profile, sign * fresh.specific_sliding, inside),
    }
    arrays: dict[str, list[np.ndarray]] = {
        name: [] for name in ("flank_height", "flank_radius", "zone", "active", "specific_sliding")
    }
    for body in range(len(BODIES)):
        nodes, places, sliding, counts = parts[body]
        height, radius = pair.flank_place(body, grid.face[:, None], nodes)
        specific, active = np.zeros(nodes.shape), np.zeros(nodes.shape, dtype=np.int8)
        for i in range(grid.face.size):
            on = np.flatnonzero(counts[:, i])
            if on.size == 0:
                continue
            order = on[np.argsort(places[on, i])]
            specific[i] = np.interp(nodes[i], places[order, i], sliding[order, i])
            active[i] = (nodes[i] >= places[order[0], i]) & (nodes[i] <= places[order[-1], i])
        zone = zones[body].of_profile(nodes.T).T
        own: tuple[np.ndarray, ...] = (height, radius, zone, active, specific)
        for name, values in zip(arrays, own, strict=True):
            arrays[name].append(values.T)
    found = {name: np.stack(values) for name, values in arrays.items()}
    if isinstance(pair, PointFlankMesh):
        found["surface_error"] = _UM * np.array(pair.surface_errors)
    return found


def wear_maps(teeth: LoadedTeeth, states: Sequence[LoadedState]) -> np.ndarray:
    """Wear depth of both bodies [um], (wear_step, body, profile, face)."""
    driven = _UM * np.stack([state.wear.T for state in states])
    if teeth.driving is None:
        return np.stack([np.zeros_like(driven), driven], axis=1)
    driving = _UM * np.stack([state.driving_wear.T for state in states if state.driving_wear is not None])
    return np.stack([driving, driven], axis=1)


def stacked(parts: Sequence[Arrays]) -> Arrays:
    """Arrays of several wear states, with the wear step as first axis."""
    return {name: np.stack([part[name] for part in parts]) for name in parts[0]}
