"""Fields and tables that effects need elsewhere in a scene, and rules over several of their fields."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping
from functools import partial

from semiwear.errors import Problem
from semiwear.scene.across import RuleBook, across
from semiwear.scene.effects import EFFECTS
from semiwear.scene.rating_tables import RatingTable
from semiwear.scene.reading import Reading
from semiwear.scene.rule import Rule
from semiwear.scene.rules import BODIES
from semiwear.scene.values import shown
from semiwear.untyped import Value

EFFECT_CROSS_RULES: RuleBook = []
_across = partial(across, EFFECT_CROSS_RULES)

# Rounding error of the sum of shares written with a few digits.
_SUM_TOLERANCE = 1e-6


def find_missing_needs(reading: Reading) -> list[Problem]:
    """Problems of missing fields and tables that effects of a scene need, each once with all effects that need it."""
    effects = deque(table for name in EFFECTS if (table := f"effects.{name}") in reading.tables)
    needed_by: dict[str, list[str]] = {}
    while effects:
        effect = effects.popleft()
        for need in _needs(effect, reading):
            if reading.has(need):
                continue
            # A missing effect has needs of its own, which are reported as well.
            if need not in needed_by and need.removeprefix("effects.") in EFFECTS:
                effects.append(need)
            needed_by.setdefault(need, []).append(f"[{effect}]")
    return [
        Problem(need, None, _allowed(need, reading.schema.rules), f"needed by {' and '.join(users)}: add it")
        for need, users in needed_by.items()
    ] + _missing_failure_mode(reading)


def _missing_failure_mode(reading: Reading) -> list[Problem]:
    """Problem of a life that ends at the first failure in a scene that rates no failure mode."""
    key = "effects.run_life.ends_at"
    modes = [f"[effects.{name}]" for name, kind in EFFECTS.items() if issubclass(kind, RatingTable)]
    rated = any(mode.strip("[]") in reading.tables for mode in modes)
    if reading.given.get(key) != "first_failure" or rated:
        return []
    return [Problem(key, "first_failure", f"needs one of {', '.join(modes)}", 'add one of them, or give "depth"')]


def _needs(effect: str, reading: Reading) -> tuple[str, ...]:
    def value_of(name: str) -> Value:
        key = f"{effect}.{name}"
        return reading.given.get(key, None if reading.has(key) else reading.schema.defaults[key])

    return EFFECTS[effect.removeprefix("effects.")].needed_with(value_of)


def _allowed(need: str, rules: Mapping[str, Rule]) -> str:
    if need in rules:
        return rules[need].allowed
    return "a table, empty for its defaults" if need.startswith("effects.") else "a table"


@_across("effects.wear_law.hardness", "case_depth_um", "transition_um")
def _transition_ends_below_the_surface(depth: float, transition: float) -> Iterator[Problem]:
    if transition > 2.0 * depth:
        allowed = f"0 to {2.0 * depth:g} um, twice case_depth_um: it must not reach the surface"
        fix = "the transition is centred at the case depth: give less, or a deeper case"
        yield Problem("effects.wear_law.hardness.transition_um", transition, allowed, fix)


@_across("effects.wear_law.lubrication", "boundary_lambda", "full_film_lambda")
def _full_film_is_thicker(boundary: float, full: float) -> Iterator[Problem]:
    if full <= boundary:
        fix = f"swap them: {full:g} and {boundary:g}" if full < boundary else "0.5 and 4 are usual"
        allowed = f"greater than boundary_lambda ({boundary:g})"
        yield Problem("effects.wear_law.lubrication.full_film_lambda", full, allowed, fix)


@_across("effects.load_spectrum", "torques_Nm", "shares")
def _a_share_for_every_torque(torques: tuple[float, ...], shares: tuple[float, ...]) -> Iterator[Problem]:
    key = "effects.load_spectrum.shares"
    if len(torques) != len(shares):
        allowed = f"as many as torques_Nm ({len(torques)})"
        yield Problem(key, shown(list(shares)), allowed, f"there are {len(shares)}: one share for each torque")
        return
    total = math.fsum(shares)
    if abs(total - 1.0) > _SUM_TOLERANCE:
        fix = f"they sum to {total:.6g}: give {shown(_normalised(shares))}"
        yield Problem(key, shown(list(shares)), "shares that sum to 1", fix)


def _normalised(shares: tuple[float, ...]) -> list[float]:
    """Shares with few digits that sum to 1; the rounding error is added to the greatest."""
    total = math.fsum(shares)
    rounded = [float(f"{share / total:.6g}") for share in shares]
    greatest = rounded.index(max(rounded))
    rest = math.fsum(rounded) - rounded[greatest]
    rounded[greatest] = float(f"{1.0 - rest:.12g}")
    return rounded


@_across("gear_pair", "pinion_teeth", "effects.pitch_error.pinion_um")
def _no_more_deviations_than_teeth(teeth: int, deviations: tuple[float, ...]) -> Iterator[Problem]:
    if len(deviations) > teeth:
        fix = f"there are {len(deviations)}: one for each tooth of the pinion, or a few that repeat around it"
        yield Problem("effects.pitch_error.pinion_um", shown(list(deviations)), f"at most {teeth} deviations", fix)


for _table in ("effects.micropitting", "effects.scuffing"):

    @_across(_table, "viscosity_40_mm2_per_s", "viscosity_100_mm2_per_s")
    def _oil_thins(cold: float, hot: float, table: str = _table) -> Iterator[Problem]:
        if hot >= cold:
            fix = "swap them" if hot > cold else "give both of the oil's data sheet"
            yield Problem(f"{table}.viscosity_100_mm2_per_s", hot, f"below viscosity_40_mm2_per_s ({cold:g})", fix)


for _body in BODIES:

    @_across("effects.flank_fracture", f"{_body}_hardness_depths_mm", f"{_body}_hardness_HV")
    def _hardness_at_every_depth(depths: Value, hardness: Value, body: str = _body) -> Iterator[Problem]:
        if depths is not None and hardness is not None and len(depths) != len(hardness):
            allowed = f"as many as {body}_hardness_depths_mm ({len(depths)})"
            fix = f"there are {len(hardness)}: one for each depth"
            yield Problem(f"effects.flank_fracture.{body}_hardness_HV", shown(list(hardness)), allowed, fix)


@_across("effects.bending", "required_safety", "numerics.tooth_compliance")
def _root_stress_needs_compliant_teeth(_: float, compliance: str) -> Iterator[Problem]:
    if compliance == "rigid":
        fix = 'rigid teeth have no root stress, which [effects.bending] needs: give "prism", or remove that table'
        yield Problem("numerics.tooth_compliance", compliance, 'other than "rigid"', fix)


@_across("effects.run_life", "body", "wear.worn_bodies")
def _life_is_of_a_worn_body(body: str, worn: tuple[str, ...]) -> Iterator[Problem]:
    if body not in worn:
        quoted = ", ".join(f'"{name}"' for name in worn)
        allowed = f"one of wear.worn_bodies: {quoted}"
        fix = f'give "{worn[0]}", or add "{body}" to wear.worn_bodies'
        yield Problem("effects.run_life.body", body, allowed, fix)
