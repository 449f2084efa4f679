"""Ratings against worked examples of standards and reports of other programs (`worked_examples.toml`).

The functions are fed with what an example prints of geometry, load and temperature. "To the digits printed" is half
of the last digit, widened by what the digits of the inputs leave open, which each test names.
"""

import tomllib
from math import acos, atan, cos, pi, prod, radians, sin, sqrt, tan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from semiwear.closed_forms import effective_modulus
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.ratings.bending import (
    bending_curve,
    relative_notch_sensitivity_factor,
    relative_surface_factor,
    size_factor,
)
from semiwear.ratings.bending import life_points as bending_points
from semiwear.ratings.flank_fracture import (
    FlankMaterial,
    line_contact_stress,
    material_exposure,
    shear_stress_intensity,
)
from semiwear.ratings.hardness import hardness_of_case
from semiwear.ratings.life_curve import LifeCurve
from semiwear.ratings.load_stages import TEST_TORQUE_NM, film_of_test, mean_friction
from semiwear.ratings.miner import StressHistory
from semiwear.ratings.oil import Oil
from semiwear.ratings.pitting import (
    PitchPoint,
    Pitting,
    life_points,
    lubricant_factor,
    pitting_curve,
    roughness_factor,
    velocity_factor,
)
from semiwear.ratings.plastic_wear import loss_factor, tooth_temperature
from semiwear.ratings.scuffing import (
    bulk_temperature_flash,
    bulk_temperature_integral,
    flash_temperature_safety,
    integral_temperature_safety,
    scuffing_integral_temperature,
    scuffing_temperature,
)
from semiwear.ratings.specific_film import FilmContact, permissible_film, specific_film
from semiwear.scene import rating_tables
from tests.strategies.spur_pair import C_GF

EXAMPLES = tomllib.loads((Path(__file__).parent / "worked_examples.toml").read_text(encoding="utf-8"))
MODULUS = effective_modulus(206e3, 0.3, 206e3, 0.3)
OIL = Oil(*(EXAMPLES["oil"][name] for name in ("family", "viscosity_40", "viscosity_100", "density_15")))
# conductivity, density and heat with the thermal contact factor of the reports, 13.78 N/(mm s^0.5 K)
STEEL = {"conductivity_W_per_mK": 50.0, "density_kg_per_m3": 7800.0, "specific_heat_J_per_kgK": 13780.0**2 / 390e3}


def each(table: str) -> pytest.MarkDecorator:
    """A case for every example of a table."""
    examples = EXAMPLES[table]
    return pytest.mark.parametrize("example", examples, ids=[example["name"] for example in examples])


def conditions(pressure: float, radius: float, speeds: tuple[float, float]) -> ContactConditions:
    """One slice of a line contact, from what the reports print of a point."""
    curvature, velocity = np.full((1, 1), 1.0 / radius), np.array(speeds)[:, None, None]
    load = pi * pressure**2 * radius / MODULUS * np.ones((1, 1))
    return ContactConditions.hertz(load, curvature, velocity, MODULUS)


def film(state: ContactConditions, contact_temperature: float, bulk: float, roughness: float) -> float:
    """Specific film of the slice."""
    temperature = np.full((1, 1), contact_temperature)
    contact = FilmContact(state.sum_speed, state.pressure, state.curvature, temperature, MODULUS)
    return float(specific_film(contact, OIL, bulk, roughness)[0, 0])


def flash(state: ContactConditions, friction: float) -> float:
    """Flash temperature of the slice [K]."""
    return float(FlashTemperature("blok", 80.0, **STEEL).rise(state, np.full((1, 1), friction))[0, 0])


def test_oil_of_the_reports():
    """Viscosity at five temperatures and the pressure-viscosity coefficient, to the digits printed."""
    printed = EXAMPLES["oil"]
    assert 1e-3 * float(OIL.pressure_viscosity(38.0)) == pytest.approx(printed["alpha_38"], abs=0.6e-5)
    for temperature, viscosity in printed["dynamic_viscosity"]:
        # the temperature itself is printed to 0.05 degrees, which are 0.3 % of the viscosity
        assert float(OIL.dynamic_viscosity(temperature)) == pytest.approx(viscosity, abs=0.05, rel=0.003)


def test_gear_of_the_test():
    """Torque, Hertz pressure and film of the C-GF test gear in stage 10.

    With the temperatures that the report prints the film is met to its two digits. Our contact is 12 K cooler where
    contact begins (240 degrees, printed 252), which makes the film of the test 5 % thicker, and the limit with it.
    """
    printed = EXAMPLES["micropitting_test"]
    assert TEST_TORQUE_NM[printed["load_stage"]] == printed["torque_Nm"]
    second = C_GF.tip_curvature[1]
    first = C_GF.action - second
    radius, speed = first * second / C_GF.action, 2250.0 * pi / 30.0
    pressure = sqrt(printed["line_load_A"] * MODULUS / (pi * radius))
    state = conditions(pressure, radius, (speed * first, speed * second * 16.0 / 24.0))
    found = film(state, printed["contact_temperature_A"], printed["bulk_temperature"], 0.5)
    assert 0.5 * found == pytest.approx(printed["film_um"], abs=0.5e-3)
    assert film_of_test(OIL, printed["load_stage"]) == pytest.approx(printed["lambda_GFT"], rel=0.06)
    assert permissible_film(printed["lambda_GFT"]) == pytest.approx(printed["lambda_GFP"], abs=0.6e-3)


@each("micropitting")
def test_micropitting_of_reports(example):
    """Friction and film of four pairs by ISO/TR 15144-1, method B: friction to the digits, film within 1 %.

    The friction is taken at the pitch point with the load of the report's factors; the temperature of the teeth is as
    printed, to 0.05 K.
    """
    z1, z2 = example["teeth"]
    tilt = cos(radians(example["base_helix"]))
    speed = example["speed_rpm"] * pi / 30.0
    c1, c2 = example["T1"]
    at_pitch = c1 * c2 / (c1 + c2) / tilt
    friction = mean_friction(
        example["line_load"] * prod(example["load_factors"]),
        2e-3 * speed * c1,
        at_pitch,
        float(OIL.dynamic_viscosity(example["oil_temperature"])),
        example["Ra"],
        1.0,
    )
    assert friction == pytest.approx(example["friction"], abs=0.5e-3)

    y1, y2 = example["TY"]
    assert y1 * abs(y2) / (y1 + abs(y2)) / tilt == pytest.approx(example["radius"], rel=1e-4)
    state = conditions(example["pressure"], example["radius"], (speed * y1, speed * abs(y2 * z1 / z2)))
    hot = example["bulk_temperature"] + flash(state, friction)
    found = film(state, hot, example["bulk_temperature"], example["Ra"])
    assert found == pytest.approx(example["lambda_GFY"], rel=0.01)
    limit = permissible_film(EXAMPLES["micropitting_test"]["lambda_GFT"], example["W_W"])
    assert limit == pytest.approx(example["lambda_GFP"], abs=0.6e-3)
    assert found / limit == pytest.approx(example["safety"], rel=0.012)  # 0.6 % from the three digits of lambda_GFT


def test_scuffing_of_a_report_by_integral_temperature():
    """The helical pair by ISO/TR 13989-2: temperatures, friction and safety to the digits printed.

    Its scuffing temperature is that of 714.2 N m instead of 3.726 S^2 = 730.3 N m: beyond stage 12 the torque of the
    test is below its formula.
    """
    printed = EXAMPLES["scuffing"]
    mean = printed["mean_flash_integral"]
    bulk = bulk_temperature_integral(printed["oil_temperature"], mean, "dip")
    assert float(bulk) == pytest.approx(printed["bulk_integral_method"], abs=0.6e-2)
    assert float(bulk) + 1.5 * mean == pytest.approx(printed["integral_temperature"], abs=0.6e-2)
    safety = integral_temperature_safety(bulk, mean, printed["scuffing_integral_temperature"])
    assert float(safety) == pytest.approx(printed["S_intS"], abs=0.6e-3)
    ours = scuffing_integral_temperature(OIL, printed["load_stage"]) - 80.0
    assert (printed["scuffing_integral_temperature"] - 80.0) / ours == pytest.approx(
        714.2 / (3.726 * 14**2), rel=1e-3
    )
    # theta_flaE = theta_flaint X_Q X_Ca/X_eps, with the whole load at the pinion's tip
    at_tip = mean * printed["X_Q"] * printed["X_Ca"] / printed["X_epsilon"]
    load, angle = printed["load_tangential"], radians(printed["working_pressure_angle"])
    sum_speed = 2.0 * printed["reference_speed"] * tan(angle) * cos(radians(printed["transverse_pressure_angle"]))
    radius = printed["centre_distance"] * sin(angle) * 24.0 * 95.0 / 119.0**2 / cos(radians(printed["base_helix"]))
    friction = mean_friction(load, sum_speed, radius, printed["viscosity"], printed["Ra"], 1.0)
    assert friction == pytest.approx(printed["friction_integral_method"], abs=0.6e-3)
    assert flash(_on_path(load, 1.0, printed["TE"][0]), friction) == pytest.approx(at_tip, rel=2e-3)


def test_scuffing_of_a_report_by_flash_temperature():
    """The helical pair by ISO/TR 13989-1: every temperature and the safety to the digits printed.

    The load is w_Bt, for Part 1 has no K_Bgamma, which the report prints for both methods; but the friction behind
    the greatest flash temperature is that of w_Bt K_Bgamma, 0.0433, while the one printed, 0.041, is that of w_Bt.
    """
    printed = EXAMPLES["scuffing"]
    limit = scuffing_temperature(OIL, printed["oil_temperature"], printed["load_stage"])
    assert limit == pytest.approx(printed["scuffing_temperature"], abs=0.6e-2)
    bulk = bulk_temperature_flash(printed["oil_temperature"], printed["mean_flash"], "dip")
    assert float(bulk) == pytest.approx(printed["bulk_flash_method"], abs=0.6e-2)
    safety = flash_temperature_safety(printed["contact_temperature"], limit, printed["oil_temperature"])
    assert float(safety) == pytest.approx(printed["S_B"], abs=0.6e-3)
    assert 1e3 * (2.0 * MODULUS) ** 0.25 / (sqrt(1e3) * printed["thermal_contact"]) == pytest.approx(
        printed["flash_factor"], rel=5e-5
    )
    load = printed["load_flash_method"]
    friction, raised = (_friction_of_part_1(at) for at in (load, printed["load_tangential"]))
    assert friction == pytest.approx(printed["friction_flash_method"], abs=0.6e-3)
    share = 1.3 / sum(printed["contact_ratios"])  # mean load and buttressing at the tip
    assert share == pytest.approx(printed["load_sharing"], abs=0.6e-3)
    rise = flash(_on_path(load, share, printed["TE"][0]), raised)
    assert rise == pytest.approx(printed["contact_temperature"] - printed["bulk_flash_method"], rel=1e-3)


def test_mean_flash_temperature_of_a_report():
    """Over the path of contact, with the friction printed: within 1 %, as the number of points decides."""
    printed = EXAMPLES["scuffing"]
    load, ratio = printed["load_flash_method"], sum(printed["contact_ratios"])
    angle = radians(printed["working_pressure_angle"])
    base = printed["centre_distance"] * cos(angle) * 24.0 / 119.0
    last = printed["TE"][0]
    first = last - ratio * 2.0 * pi * base / 24.0
    buttressed = 0.2 * sin(radians(printed["base_helix"])) * base * tan(angle)
    rises = []
    for at in np.linspace(first, last, 201):
        share = (1.0 + 0.3 * max(1.0 - min(at - first, last - at) / buttressed, 0.0)) / ratio
        rises.append(flash(_on_path(load, share, at), _friction_of_part_1(load)))
    assert np.trapezoid(rises) / 200.0 == pytest.approx(printed["mean_flash"], rel=0.012)


def _friction_of_part_1(load: float) -> float:
    """0.060 (w/(v_SigmaC rho_C))^0.2 X_L X_R, X_L = eta^-0.05 and X_R = sqrt(Ra), of ISO/TR 13989-1."""
    printed = EXAMPLES["scuffing"]
    angle = radians(printed["working_pressure_angle"])
    radius = printed["centre_distance"] * sin(angle) * 24.0 * 95.0 / 119.0**2
    speed = 2.0 * printed["reference_speed"] * sin(angle)
    return 0.060 * (load / (speed * radius)) ** 0.2 * printed["viscosity"] ** -0.05 * sqrt(printed["Ra"])


def _on_path(load: float, share: float, first: float) -> ContactConditions:
    """Contact of the helical pair where the pinion's transverse radius of curvature is `first` [mm]."""
    printed = EXAMPLES["scuffing"]
    second = sum(printed["TE"]) - first
    radius = first * second / (first + second) / cos(radians(printed["base_helix"]))
    normal = share * load / cos(radians(printed["transverse_pressure_angle"]))
    speeds = [n * pi / 30.0 * r for n, r in zip(printed["speed_rpm"], (first, second), strict=True)]
    return conditions(sqrt(normal * MODULUS / (pi * radius)), radius, (speeds[0], speeds[1]))


@pytest.mark.parametrize("gear", [0, 1])
def test_flank_fracture_of_a_report(gear):
    """ISO DTR 19042-1 on the helical pair: strength to the digits, the load's stress 4 % and the exposure 17 % lower.

    Strength: Lang's curve with y over the case depth, 0.4 MPa/HV and K_material. The exposure is the ratio of stress
    and strength plus 0.04. Their stress is a fit that lies 4 % above the stress of the Hertz contact even with the
    residual stress that reduces it; ours, added as tensors, takes another 9 % off. Our curve meets 550 HV at the case
    depth, theirs 530, which makes our strength 3 % greater.
    """
    printed = EXAMPLES["flank_fracture"]
    core, surface, case = printed["core_HV"], printed["surface_HV"], printed["case_depth"]
    factor, depth = printed["K_material"][gear], printed["depth"]

    lang = _hardness_of_report
    strength = 0.4 * factor * float(lang(depth))
    assert strength == pytest.approx(printed["strength"][gear], rel=0.6e-3)  # K_material has four digits
    exposure = printed["stress"] / printed["strength"][gear] + 0.04
    assert exposure == pytest.approx(printed["exposure"][gear], abs=0.6e-3)

    width = 2.0 * printed["pressure"] * printed["radius"] / MODULUS
    of_load = float(shear_stress_intensity(line_contact_stress(printed["pressure"], depth / width)))
    assert of_load / printed["stress"] == pytest.approx(0.96, abs=0.005)
    ours = [
        material_exposure(np.array(printed["pressure"]), np.array(width), FlankMaterial(hardness, core, factor))
        for hardness in (lang, hardness_of_case(surface, core, case))
    ]
    assert float(ours[0][0]) / printed["exposure"][gear] == pytest.approx(0.88, abs=0.01)
    assert float(ours[1][0]) / printed["exposure"][gear] == pytest.approx(0.83, abs=0.01)
    assert float(ours[0][1]) == pytest.approx(depth, abs=0.1)  # mm; the report's depths are 0.1 mm apart


@pytest.mark.parametrize("gear", [0, 1])
def test_flank_fracture_safety_of_a_report(gear):
    """A factor on the pressure: with it stress meets strength, as ours grows with pressure, within 0.5 %."""
    printed = EXAMPLES["flank_fracture"]
    material = FlankMaterial(_hardness_of_report, printed["core_HV"], printed["K_material"][gear])

    def stress_over_strength(pressure: float) -> float:
        width = 2.0 * pressure * printed["radius"] / MODULUS
        return float(material_exposure(np.array(pressure), np.array(width), material)[0]) - 0.04

    there = (printed["exposure"][gear] - 0.04) / stress_over_strength(printed["pressure"])
    at_limit = brentq(lambda s: there * stress_over_strength(s * printed["pressure"]) - 1.0, 0.5, 1.5)
    assert at_limit == pytest.approx(printed["S_FF"][gear], rel=5e-3)


def _hardness_of_report(depth: Any) -> np.ndarray:
    """Lang's curve over the case depth [HV]."""
    printed = EXAMPLES["flank_fracture"]
    x = np.asarray(depth, float) / printed["case_depth"]
    fall = 10.0 ** -(0.0381 * x + 0.2662 * x**2)
    return np.asarray(printed["core_HV"] + (printed["surface_HV"] - printed["core_HV"]) * fall)


@each("pitting")
def test_film_and_life_factors(example):
    """Z_L, Z_v, Z_R, Z_NT and the permissible pressure of five pairs, to the digits printed."""
    limit = min(example["limits"])
    radius = example.get("radius") or _radius(**example["tooth"])
    factors = (
        lubricant_factor(limit, example["viscosity_40"]),
        velocity_factor(limit, example["speed"]),
        roughness_factor(limit, example["Rz"], radius),
    )
    digit = 0.6e-5 if example["name"].startswith("ISO") else 0.6e-3
    for name, found in zip(("Z_L", "Z_v", "Z_R"), factors, strict=True):
        assert found == pytest.approx(example[name], abs=digit), name
    for i, allowed in enumerate(example["permissible"]):
        points, cycles = np.array(life_points("hardened", 0.85)), example["cycles"][i]
        life = float(np.exp(np.interp(np.log(cycles), *np.log(points).T)))
        assert life == pytest.approx(example["Z_NT"][i], abs=0.6e-3)
        curve = pitting_curve(example["limits"][i], "hardened", 0.85, prod(factors), example["Z_W"][i])
        # the reports print the speed to three digits and Z_W to four
        assert float(curve.permissible(cycles)) == pytest.approx(allowed, rel=1e-3)


@each("pitting")
@pytest.mark.parametrize("size", [1.0, 0.9])
def test_a_table_of_the_scene_permits_those_pressures(example, size):
    """Films are those of the softer flank, Z_W hardens the gear alone, and Z_X counts in full beyond 5e7 cycles."""
    table = rating_tables.Pitting(
        pinion_limit_MPa=example["limits"][0],
        gear_limit_MPa=example["limits"][1],
        pinion_life_curve="hardened",
        gear_life_curve="hardened",
        viscosity_40_mm2_per_s=example["viscosity_40"],
        roughness_Rz_um=example["Rz"],
        gear_work_hardening_factor=example["Z_W"][1],
        size_factor=size,
    )
    radius = example.get("radius") or _radius(**example["tooth"])
    curves = Pitting.of(table, PitchPoint(radius, example["speed"])).curves
    for curve, cycles, allowed in zip(curves, example["cycles"], example["permissible"], strict=True):
        assert float(curve.permissible(cycles)) == pytest.approx(size * allowed, rel=1e-3)


def _radius(module: float, teeth: tuple[int, int], helix: float, centre: float) -> float:
    """Radius of relative curvature at the pitch point, transverse [mm]."""
    z1, z2 = teeth
    angle = atan(tan(radians(20.0)) / cos(radians(helix)))
    base = 0.5 * module / cos(radians(helix)) * cos(angle)
    return z1 * z2 / (z1 + z2) * base * tan(acos(base * (z1 + z2) / centre))


@each("bending")
def test_root_factors(example):
    """Y_delta_relT, Y_R_relT, Y_X, Y_NT and the permissible root stress of six gears, to the digits printed."""
    thickness, radius = example["section"]
    notch = relative_notch_sensitivity_factor(thickness / (2.0 * radius), 0.0030)
    surface, size = relative_surface_factor("case_hardened", 20.0), size_factor("case_hardened", example["module"])
    assert notch == pytest.approx(example["Y_delta"], abs=0.6e-3)
    assert surface == pytest.approx(0.957, abs=0.6e-3)
    assert size == pytest.approx(example["Y_X"], abs=0.6e-3)
    points = np.array(bending_points("case_hardened", 0.85))
    life = float(np.exp(np.interp(np.log(example["cycles"]), *np.log(points).T)))
    assert life == pytest.approx(example["Y_NT"], abs=0.6e-3)
    curve = bending_curve(430.0, "case_hardened", 0.85, notch, surface * size, example["Y_M"])
    assert float(curve.permissible(example["cycles"])) == pytest.approx(example["permissible"], rel=1e-3)


def test_load_spectrum_of_the_standard():
    """ISO 6336-6, annex C: lives of 42 bins within the digits of their stresses, and a damage of 1 with S_H = 1.374.

    The annex applies the film factors at every number of cycles and goes on beyond 1.6 times the limit below 1e5
    cycles; here likewise, which is why the curve is made from the life factors alone. Stresses of four digits and
    factors of three leave up to 4 % of a life open.
    """
    spectrum = EXAMPLES["spectrum"]
    stress, count, factor, life, damage = np.array(spectrum["bins"]).T
    endurance = spectrum["limit"] * prod(spectrum["film"])
    np.testing.assert_allclose(stress / endurance, factor, atol=0.006)
    cycles, factors = np.array(life_points("hardened", 0.85)).T
    start = 2e4  # the same straight line, on to where no bin is above it
    slope = np.log(factors[0] / factors[1]) / np.log(cycles[1] / cycles[0])
    cycles[0], factors[0] = start, (cycles[1] / start) ** slope
    curve = LifeCurve(tuple(cycles), tuple(endurance * factors))
    with np.errstate(divide="ignore"):
        found = 1.0 / curve.damage_per_cycle(np.log(stress))
    np.testing.assert_allclose(found, life, rtol=0.02)
    assert damage.sum() == pytest.approx(1.0, abs=0.01)
    history = StressHistory(
        cycles=np.array([0.0, count.sum()]),
        shares=count / count.sum(),
        stress=np.repeat(stress[None, :, None] / 1.374, 2, axis=0),
        curve=curve,
    )
    safety = history.least_safeties()[0][1]
    assert safety == pytest.approx(1.374, rel=1e-3)


@each("plastic")
def test_temperature_of_plastic_teeth(example):
    """VDI 2736: temperatures of root and flank from the printed loss, to the digits printed.

    30 teeth of module 2 mm and 15 mm width at 1000 rpm; k_theta 9000 and 2148 K (m/s)^0.75 mm^1.75/W, open housing.
    """
    speed = 2.0 * pi * 1000.0 / 60.0 * 0.030
    for place, coefficient in (("flank", 9000.0), ("root", 2148.0)):
        resistance = coefficient / (15.0 * 30.0 * (speed * 2.0) ** 0.75)
        found = tooth_temperature(example["surroundings"], example["loss_power"], resistance, 0.0)
        assert found == pytest.approx(example[f"{place}_temperature"], abs=0.08)  # 0.05 of it from the loss


@each("loss_factor")
def test_loss_factors(example):
    """H_V of three spur pairs, to the digits printed."""
    z1, z2 = example["teeth"]
    base, tip = np.array(example["base"]), np.array(example["tip"])
    pitch = base * tan(acos(base.sum() / example["centre"]))
    first, second = (np.sqrt(tip**2 - base**2) - pitch) / (2.0 * pi * base[0] / z1)
    assert loss_factor((z1, z2), (float(first), float(second))) == pytest.approx(example["H_V"], abs=0.6e-4)
