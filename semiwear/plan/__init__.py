"""Chooses the physics of a scene and builds it; no other module decides what runs.

`choices` lists what was chosen and why, `teeth` and `effects` build it. Physics that is not chosen is not
constructed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.closed_forms.hertz import effective_modulus, line_contact_half_width
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.contact.fidelity import Fidelity
from semiwear.contact.footprint import footprints
from semiwear.contact.line_contact import LINE, SMOOTH_LINE
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth, fresh_flanks, slices_near
from semiwear.contact.patch_gap import PatchCells
from semiwear.contact.problem import ContactProblem, usual_approach
from semiwear.effect_clock import EffectClock
from semiwear.errors import SceneError
from semiwear.html_text import folded_html, html_table
from semiwear.meshing.contact_lines import ContactLines, face_stations
from semiwear.meshing.driving_flank import DrivingFlank, driving_flank, driving_grid
from semiwear.meshing.flank_grid import FlankGrid, flank_grid
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING, FlankPair, reference_lever
from semiwear.meshing.pairs import flank_pair, on_loaded_flank
from semiwear.meshing.roll_grid import RollGrid, even_roll_grid, given_roll_grid, pairs_that_can_touch
from semiwear.plain_text import table
from semiwear.plan import effects
from semiwear.plan.choices import Choice, parts_deep_steps, physics_choices
from semiwear.plan.compared import Compared
from semiwear.plan.effects_table import effects_table, seconds_of_effects
from semiwear.plan.kept_lines import contact_lines, lines_at, middle_contact
from semiwear.plan.load_cases import WearingTorques, load_cases, pushed_back
from semiwear.plan.named_data import data_choices
from semiwear.plan.ratings import Known, Ratings, named_modes, rated_contact, rated_states
from semiwear.plan.teeth import elastic, tooth_compliance
from semiwear.scene import Placement, Scene
from semiwear.scene.external import file_digests
from semiwear.wear.adaptive import AdaptiveStepper
from semiwear.wear.mapping import InterpolatedWear, MarchedWear
from semiwear.wear.step_count import PLAIN_STEPS, depth_of_step, steps_of_life
from semiwear.wear.stepping import ControlPoint, WearState, WearStepper
from semiwear.wear.two_stage import TwoStageStepper
from semiwear.wear.worn import WearMultipliers

if TYPE_CHECKING:
    from xarray import DataTree

    from semiwear.observers import Observer
    from semiwear.wear.contact_factor import ContactFactor

__all__ = ["Choice", "Compared", "Plan", "plan"]

_HEAD = ("physics", "runs", "chosen", "why")
_FINE_PER_POSITION = 3  # fine roll positions, on which wear is summed, per solved position
_FINE_ROLLS = (48, 96)  # least and most fine positions of a mesh cycle, unless more are solved
_REACH = 4.0  # separation up to which slices are candidates, over a typical approach, in addition to future wear
_WEAR_TO_COME = 8.3e-3  # allowance for future wear, over the base pitch


@dataclass(frozen=True)
class Plan:
    """The physics of a scene, printed as a table and built on demand.

    Attributes
    ----------
    scene : Scene
    choices : tuple of Choice
    last : mapping
        Seconds of each effect in an earlier run, and of the whole run under `""`; empty without an earlier run.
    clock : EffectClock
        Seconds of each effect in this plan.
    """

    scene: Scene
    choices: tuple[Choice, ...]
    last: Mapping[str, float] = field(default_factory=dict)
    clock: EffectClock = field(default_factory=EffectClock, compare=False, repr=False)
    compared: Compared | None = None

    def __str__(self) -> str:
        return f"{table(_HEAD, self._rows())}\n\n{self._effects()}"

    def _repr_html_(self) -> str:
        physics = html_table(_HEAD, self._rows(), "what runs, and why")
        return physics + folded_html("effects", f"<pre>{escape(self._effects())}</pre>")

    def _rows(self) -> list[tuple[str, str, str, str]]:
        return [(c.slot, "yes" if c.runs else "no", c.chosen, c.why) for c in self.choices]

    def _effects(self) -> str:
        """Table of the effects, with the cost of those that need additional wear steps."""
        costs, life = dict[str, str](), self.scene.effects.run_life
        if life is not None:
            steps = steps_of_life(1e-3 * life.depth_limit_um, self.flank_pair().base_pitch)
            costs["run_life"] = f"costs about {steps} wear steps in two stages after the run's own"
        return effects_table(self.scene, self.last, costs)

    @property
    def references(self) -> tuple[str, ...]:
        """Published sources of the physics that runs."""
        found = [source for choice in self.choices if choice.runs for source in choice.references]
        found += [source for _, table in self.scene.effects.present() for source in table.references]
        return tuple(dict.fromkeys(found))

    @property
    def modulus(self) -> float:
        """Effective modulus E* of the two materials [MPa]."""
        material = self.scene.material
        return effective_modulus(*elastic(material.pinion), *elastic(material.gear))

    @property
    def rates(self) -> bool:
        """Whether failure modes are rated."""
        return bool(named_modes(self.scene))

    @cached_property
    def input_files(self) -> dict[str, str]:
        """SHA-256 digests of the files named by the scene, by path."""
        return file_digests(self.scene.to_dict())

    def flank_pair(self, placement: Placement | None = None) -> FlankPair:
        """The two flanks in mesh; a placement replaces the scene's `[effects.misalignment]`."""
        misaligned = self.scene.effects.misalignment
        if placement is None and misaligned is not None:
            placement = misaligned.placement
        flank = self.scene.operation.loaded_flank
        return flank_pair(*on_loaded_flank(self.scene.gear_pair, placement or Placement(), flank))

    @one_blas_thread()
    def loaded_teeth(
        self,
        placement: Placement | None = None,
        roll_positions: FloatArray | None = None,
        face: FloatArray | None = None,
    ) -> LoadedTeeth:
        """Model of the loaded contact of all tooth pairs; `face` gives the middles of equal slices."""
        scene, numerics, modulus = self.scene, self.scene.numerics, self.modulus
        _ = self.input_files  # digests at the time of reading
        pair = self.flank_pair(placement)
        torque = 1e3 * scene.operation.pinion_torque_Nm
        wearing, (low, high) = self._wearing_torques(pair), pair.face_limits
        usual, greatest = (
            wearing.load(torque_Nm) / (0.5 * (high - low))
            for torque_Nm in (wearing.mean_over_wear, max(scene.operation.pinion_torque_Nm, *wearing.torques))
        )
        reach = _REACH * usual_approach(greatest, modulus) + _WEAR_TO_COME * pair.base_pitch
        reach += effects.most_set_back(scene)
        rolls = _roll_grid(scene, pair, reach, roll_positions)
        if face is None:
            face = face_stations(self.flank_pair(Placement()), numerics.face_slices)
        fresh = contact_lines(pair, rolls, face)
        grid = flank_grid(pair, face, numerics.profile_points)
        shape = self._shape(pair, rolls, fresh, grid)
        lines = shape.lines
        elastic_teeth = tooth_compliance(scene, pair, fresh[1], self.compared)
        _ = elastic_teeth.bodies  # they are prepared here, as are the errors of their data
        across = wearing.middle.curvature[0, 1]
        half_width = float(line_contact_half_width(np.array(usual), np.array(across), modulus))
        whole = wearing.half_width(scene.operation.pinion_torque_Nm)
        patches = numerics.fidelity == "patch"
        problem = ContactProblem(
            lines=lines,
            per_cycle=rolls.phase.size,
            teeth=elastic_teeth,
            torque=np.full(rolls.phase.size, torque),
            reach=reach,
            modulus=modulus,
            usual_load=usual,
            usual_half_width=half_width,
            base_pitch=pair.base_pitch,
            max_iterations=numerics.max_iterations,
            more=effects.further_compliance(scene, pair, lines, elastic_teeth, half_width, self.clock),
            cells=PatchCells(lines, grid, whole / numerics.cells_per_half_width) if patches else None,
        )
        return LoadedTeeth(
            pair=pair,
            rolls=rolls,
            fine=shape.fine,
            lines=lines,
            grid=grid,
            problem=problem,
            fidelity=effects.rubbing(scene, pair, lines, _fidelity(patches, self.compared is not None)),
            half_width=whole,
            zero=self._unworn_zero(pair, rolls, grid, shape, problem, whole),
            modification=shape.modification,
            driving=self._driving(pair, shape.fine, grid, problem.is_near(shape.fine)),
            smooth=self.compared is not None,
        )

    @one_blas_thread()
    def teeth_between(self, teeth: LoadedTeeth, phase: FloatArray) -> LoadedTeeth:
        """Teeth of this plan at other phases of the mesh cycle; they share all that does not depend on these."""
        scene, pair, before, driving = self.scene, teeth.pair, teeth.problem, teeth.driving
        rolls = given_roll_grid(teeth.rolls.start, teeth.rolls.pairs, teeth.rolls.start + phase)
        fresh = lines_at(pair, rolls, teeth.grid.face)
        shape = self._shape(pair, rolls, (fresh, fresh), teeth.grid)
        lines, elastic_teeth = shape.lines, tooth_compliance(scene, pair, fresh, self.compared, recurs=False)
        half_width = before.usual_half_width
        problem = replace(
            before.on_lines(lines),
            per_cycle=rolls.phase.size,
            teeth=elastic_teeth,
            torque=np.full(rolls.phase.size, 1e3 * scene.operation.pinion_torque_Nm),
            more=effects.further_compliance(scene, pair, lines, elastic_teeth, half_width, self.clock),
        )
        if driving is not None:
            driving = driving_flank(driving.grid, shape.fine, teeth.grid, problem.is_near(shape.fine))
        return replace(
            teeth,
            rolls=rolls,
            fine=shape.fine,
            lines=lines,
            problem=problem,
            fidelity=effects.rubbing(scene, pair, lines, _fidelity(before.cells is not None, teeth.smooth)),
            modification=shape.modification,
            driving=driving,
        )

    def wear_stepper(self, teeth: LoadedTeeth) -> WearStepper:
        """Wear stepper of the scene, which must have a table [wear]."""
        wear, numerics = self.scene.wear, self.scene.numerics
        assert wear is not None
        ratio = teeth.pair.driving_meshes
        k = [wear.coefficient(body) if body in wear.worn_bodies else 0.0 for body in BODIES]
        hardness = effects.hardness_laws(self.scene, teeth)
        swept = InterpolatedWear()
        if hardness is not None:
            swept = InterpolatedWear(hardness[DRIVEN].advance, hardness[DRIVING].advance)
        wearing = self._wearing_torques(teeth.pair)
        spread = self.scene.effects.load_spectrum is not None
        return WearStepper(
            teeth,
            WearMultipliers(k[DRIVEN], k[DRIVING] * ratio),
            numerics.wear_scheme != "explicit",
            MarchedWear(swept) if numerics.wear_mapping == "marched" else swept,
            cases=load_cases(teeth, wearing, effects.pitch_sequences(self.scene, teeth.pair, teeth.rolls.pairs)),
            factor=self._coefficient_factor(teeth),
            depth_factor=hardness[DRIVEN].factor if hardness is not None else None,
            spreading=replace(teeth, half_width=wearing.mean_half_width) if spread else None,
        )

    def wear_steps(self, stepper: WearStepper) -> WearStepper | TwoStageStepper | AdaptiveStepper:
        """Stepper for the run: plain, in two stages, or adaptive for a requested accuracy."""
        numerics = self.scene.numerics
        if numerics.accuracy is None or "wear_steps" not in numerics.chosen_for_accuracy or not stepper.implicit:
            return TwoStageStepper(stepper) if numerics.wear_scheme == "two-stage" else stepper
        assert self.scene.wear is not None
        until = self.scene.wear.until
        end = 1e-3 * until.control_depths_um[-1] if until.control_depths_um is not None else until.meshes
        assert end is not None
        return AdaptiveStepper.for_accuracy(replace(stepper, theta=1.0), numerics.accuracy, end)

    def depth_of_part(self, teeth: LoadedTeeth) -> float | None:
        """Depth of the parts into which deep steps to control depths are divided [mm]; None if they are not."""
        if not parts_deep_steps(self.scene):
            return None
        plain = depth_of_step(teeth.pair.base_pitch)
        return PLAIN_STEPS * plain if self.scene.numerics.wear_scheme == "two-stage" else plain

    def control_point(self, teeth: LoadedTeeth) -> ControlPoint | None:
        """The control point on its body's flank, if the scene names one."""
        wear = self.scene.wear
        if wear is None or wear.control_point is None:
            return None
        point, body = wear.control_point, BODIES.index(wear.watched_body)
        face = teeth.grid.face
        if body == DRIVEN:
            profile = teeth.pair.profile_at(face, np.full(face.size, point.height_mm))
            return ControlPoint(point.station_mm, profile)
        assert teeth.driving is not None
        nodes = teeth.driving.grid.profile
        heights, _ = teeth.pair.flank_place(DRIVING, face[:, None], nodes)
        read = [np.interp(point.height_mm, height, own) for height, own in zip(heights, nodes, strict=True)]
        return ControlPoint(point.station_mm, np.array(read), DRIVING)

    def observers(self, teeth: LoadedTeeth) -> tuple[Observer, ...]:
        """Effects that evaluate a loaded state without changing it."""
        scene = self.scene
        rubbing, film = effects.friction(scene), effects.film_thickness(scene, teeth.problem.modulus)
        flash = effects.flash_temperature(scene)
        if rubbing is None and film is None and flash is None:
            return ()
        from semiwear import observers

        speeds = effects.speeds_of(scene, teeth.pair, teeth.lines)
        found: list[Observer] = []
        if rubbing is not None:
            power = scene.operation.pinion_torque_Nm * speeds.power_per_torque
            speed_known = scene.operation.pinion_speed_rpm is not None
            found.append(observers.FrictionLoss(speeds, rubbing, power, speed_known))
        if flash is not None:
            found.append(observers.Heat(speeds, effects.friction_of_heat(scene), flash))
        if film is not None:
            found.append(observers.Film(speeds, film))
        return tuple(found)

    def ratings(
        self,
        stepper: WearStepper,
        states: Sequence[WearState],
        hours_per_mesh: float | None,
        known: Sequence[Known] = (),
    ) -> Ratings | None:
        """Ratings of the failure modes for wear states, the first of them unworn; None if the scene has none.

        Arguments are those of `semiwear.plan.ratings.rated_states`.
        """
        return rated_states(self.scene, stepper, states, hours_per_mesh, self.clock, known)

    def contact_ratings(
        self, teeth: LoadedTeeth, contact: LoadedState, meshes: float, hours_per_mesh: float | None, known: Known
    ) -> Ratings | None:
        """Ratings of the failure modes for one wear state; None if the scene has none.

        Arguments are those of `semiwear.plan.ratings.rated_contact`.
        """
        if not self.rates:
            return None
        stepper = self.wear_stepper(teeth)
        return rated_contact(self.scene, stepper, contact, meshes, hours_per_mesh, self.clock, known)

    # ---- parts

    def _shape(
        self, pair: FlankPair, rolls: RollGrid, fresh: tuple[ContactLines, ContactLines], grid: FlankGrid
    ) -> _Shape:
        """From fresh lines on the fine roll grid and at the solved positions."""
        scene, (fine, lines) = self.scene, fresh
        sequences = effects.pitch_sequences(scene, pair, rolls.pairs)
        if sequences:
            fine = pushed_back(fine, sequences[0].gap)
            lines = fine.every(rolls.substeps)
        modification = None
        if effects.deviates(scene):
            with self.clock.measure("modification"):
                modification = effects.deviation_depth(scene, pair, fine, grid)
        return _Shape(fine, lines, modification)

    def _driving(self, pair: FlankPair, fine: ContactLines, grid: FlankGrid, near: BoolArray) -> DrivingFlank | None:
        wear = self.scene.wear
        if wear is None or BODIES[DRIVING] not in wear.worn_bodies:
            return None
        return driving_flank(driving_grid(pair, grid.face, grid.profile.shape[1]), fine, grid, near)

    def _unworn_zero(
        self,
        pair: FlankPair,
        rolls: RollGrid,
        grid: FlankGrid,
        shape: _Shape,
        problem: ContactProblem,
        half_width: float,
    ) -> float:
        """Mean over an even mesh cycle of the least separation [mm]."""
        positions = self.scene.numerics.roll_positions
        even = even_roll_grid(rolls.start, rolls.pairs, positions, positions)
        if not np.array_equal(rolls.phase, even.phase):
            shape, rolls = self._shape(pair, even, contact_lines(pair, even, grid.face), grid), even
        unworn = fresh_flanks(shape.fine, grid, shape.modification)
        touch = footprints(shape.fine, unworn, half_width, slices_near(problem, shape.fine, unworn))
        least = touch.every(rolls.substeps).least
        least = least * (reference_lever(pair) / shape.lines.lever_arm)
        return float(least.min(axis=1).reshape(rolls.pairs, -1).min(axis=0).mean())

    def _wearing_torques(self, pair: FlankPair) -> WearingTorques:
        return WearingTorques(self.scene, pair, middle_contact(self.flank_pair(Placement())), self.modulus)

    def _coefficient_factor(self, teeth: LoadedTeeth) -> ContactFactor | None:
        laws = effects.contact_laws(self.scene, teeth.problem.modulus)
        if not laws:
            return None
        from semiwear.wear.contact_factor import ContactFactor

        speeds = effects.speeds_of(self.scene, teeth.pair, teeth.lines)
        return ContactFactor(laws, speeds, self.clock, effects.running_in(self.scene, "wear_law"))


@dataclass(frozen=True)
class _Shape:
    """Fresh contact lines on the fine roll grid and at the solved positions, and modification depths."""

    fine: ContactLines
    lines: ContactLines
    modification: FloatArray | None


def plan(scene: Scene, last: DataTree | None = None) -> Plan:
    """Plan of a scene: which physics will run, which will not, and why.

    Parameters
    ----------
    scene : Scene
    last : DataTree, optional
        An earlier result; the table then shows the share of each effect in its computing time.

    Raises
    ------
    SceneError
        `last` has no times.

    Examples
    --------
    >>> import semiwear as sw
    >>> print(str(sw.plan(sw.load_scene("spur_fzg_c"))).splitlines()[2])
    geometry          yes   spur gears 16/24, profile shifts 0.1817, 0.1715  gear_pair.type = "cylindrical"
    """
    seconds = {} if last is None else seconds_of_effects(last)
    if last is not None and not seconds:
        raise SceneError.of("last", str(last.attrs.get("title", "")), "a result of `simulate`", "it has no times")
    return Plan(scene, (*physics_choices(scene), *data_choices(scene)), seconds)


def _fidelity(patches: bool, smooth: bool) -> Fidelity:
    """Fidelity `patch`, imported only where chosen, or `line`."""
    if not patches:
        return SMOOTH_LINE if smooth else LINE
    from semiwear.contact.patch_contact import PATCH

    return PATCH


def _roll_grid(scene: Scene, pair: FlankPair, reach: float, roll_positions: FloatArray | None) -> RollGrid:
    number = scene.numerics.tooth_pairs
    if number == "auto":
        start, pairs = pairs_that_can_touch(pair, reach)
    else:
        # the pairs nearest to the pitch point
        start, pairs = -0.5 * int(number), int(number)
    if roll_positions is not None:
        return given_roll_grid(start, pairs, roll_positions)
    positions = scene.numerics.roll_positions
    fine = min(max(_FINE_PER_POSITION * positions, _FINE_ROLLS[0]), _FINE_ROLLS[1])
    return even_roll_grid(start, pairs, positions, fine)
