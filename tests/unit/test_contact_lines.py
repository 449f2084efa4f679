"""Contact lines: what they keep about their places is what geometry says there, at borders of the flanks as well."""

from dataclasses import dataclass

import numpy as np
import pytest

import semiwear as sw
from semiwear.meshing.contact_lines import (
    ContactLines,
    change_along_line,
    end_rounding,
    face_stations,
    trace_contact_lines,
)
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.scene import Placement

ROLLS = np.array([-0.9, -0.6, 0.0, 0.5, 0.9])
BESIDE = 1e-3  # mm of profile, for differences


@dataclass
class Traced:
    """A pair with its lines at nominal edges, and where places have neighbours on the same side of all bends."""

    pair: FaceGearMesh
    lines: ContactLines
    even: np.ndarray
    held: np.ndarray

    def at(self, beside: float = 0.0):
        """The meeting of places beside the lines."""
        lines = self.lines
        return self.pair.meeting(lines.face[None], lines.profile + beside, lines.roll[:, None])

    def slope(self, values) -> np.ndarray:
        """Derivative by the profile coordinate of what `values` makes of a meeting."""
        return (values(self.at(BESIDE)) - values(self.at(-BESIDE))) / (2.0 * BESIDE)


@pytest.fixture(scope="module", params=[Placement(), Placement(offset_mm=0.05, pinion_slope_mrad=1.0)], ids=str)
def traced(shipped: sw.Scene, request: pytest.FixtureRequest) -> Traced:
    pair = FaceGearMesh(shipped.gear_pair, request.param)
    lines = trace_contact_lines(pair, ROLLS, face_stations(pair, 41), sharp=True)
    side = (lines.profile >= lines.high).astype(int) - (lines.profile <= lines.low)
    even = np.zeros(side.shape, dtype=bool)
    even[:, 1:-1] = (side[:, 1:-1] == side[:, :-2]) & (side[:, 1:-1] == side[:, 2:])
    even &= np.isfinite(lines.separation[0])
    assert (even & (side == 0)).sum() > 60 and (even & (side != 0)).sum() > 10
    return Traced(pair, lines, even, side != 0)


def test_separation_and_its_derivatives_are_those_at_the_line(traced: Traced) -> None:
    value, first, second = traced.lines.separation[:3]
    here = traced.even
    np.testing.assert_allclose(value[here], traced.at().separation[here], atol=1e-8)
    slope = traced.slope(lambda met: met.separation)
    np.testing.assert_allclose(first[here], slope[here], rtol=5e-4, atol=2e-5)
    # away from borders the separation is least
    assert np.abs(first[here & ~traced.held]).max() < 1e-6 < np.abs(first[here & traced.held]).max()
    steps = [traced.at(50.0 * k * BESIDE).separation for k in (-1, 0, 1)]
    bend = (steps[0] - 2.0 * steps[1] + steps[2]) / (50.0 * BESIDE) ** 2
    np.testing.assert_allclose(second[here], bend[here], rtol=2e-3)
    # a length across the line is the spacing times that of the profile coordinate
    np.testing.assert_allclose((traced.lines.curvature * traced.lines.spacing**2)[here], bend[here], rtol=2e-3)


def test_the_driving_flank_is_met_where_the_lines_say(traced: Traced) -> None:
    lines, here = traced.lines, traced.even
    np.testing.assert_allclose(lines.driving_profile[here], traced.at().driving_profile[here], atol=1e-6)
    slope = traced.slope(lambda met: met.driving_profile)
    np.testing.assert_allclose(lines.driving_slope[here], slope[here], rtol=2e-3)
    beside = traced.at(0.05).driving_profile
    np.testing.assert_allclose(lines.on_driving(lines.profile + 0.05)[here], beside[here], atol=1e-3)


def test_sliding_is_split_along_and_across_the_line(traced: Traced) -> None:
    lines, pair, here = traced.lines, traced.pair, traced.even
    tangent = np.gradient(traced.at().position, lines.face, axis=1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    across = traced.slope(lambda met: met.position)
    across -= np.sum(across * tangent, axis=-1, keepdims=True) * tangent
    np.testing.assert_allclose(lines.spacing[here], np.linalg.norm(across, axis=-1)[here], rtol=2e-3)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)

    def parts(met) -> np.ndarray:
        velocity = pair.sliding(met.position)
        return np.stack([np.sum(velocity * one, axis=-1) for one in (across, tangent)], axis=-1)

    fastest = np.abs(lines.sliding[here]).max()
    np.testing.assert_allclose(lines.sliding[here], parts(traced.at())[here], atol=1e-3 * fastest)
    np.testing.assert_allclose(
        lines.sliding_slope[here], traced.slope(parts)[here], atol=2e-3 * np.abs(lines.sliding_slope[here]).max()
    )


def test_lengths_add_up_along_the_line(traced: Traced) -> None:
    lines = traced.lines
    chords = np.linalg.norm(np.diff(traced.at().position, axis=1), axis=-1)
    both = traced.even[:, 1:] & traced.even[:, :-1]
    np.testing.assert_allclose(np.diff(lines.arc, axis=1)[both], chords[both], rtol=2e-3)
    np.testing.assert_allclose(lines.arc[:, 0], 0.5 * lines.length[:, 0])


def test_the_driving_tip_ends_slices_and_has_its_edge_there(shipped: sw.Scene) -> None:
    pair = FaceGearMesh(shipped.gear_pair, Placement())
    lines = trace_contact_lines(pair, ROLLS, face_stations(pair, 41))
    borders = pair.borders(lines.face)
    cut = lines.low > borders.root
    assert 10 < cut.sum() < cut.size - 10
    met = pair.meeting(lines.face[None], lines.low, lines.roll[:, None]).driving_profile
    inside = cut & (lines.low < lines.high)
    np.testing.assert_allclose(met[inside], borders.driving_tip, atol=1e-5)
    np.testing.assert_array_equal(lines.low_edge_radius, np.where(cut, borders.driving_tip_edge_radius, 0.0))


def test_slices_in_the_roundings_of_both_ends_fall_off(shipped: sw.Scene) -> None:
    """The pinion ends 1 and 2 mm before the gear, and its ends are rounder."""
    changes = {
        "pinion_face_width_mm": 77.0, "pinion_centre_mm": 519.5, "pinion_end_edge_radius_mm": 1.5,
        "pinion_tip_edge_radius_mm": 0.0, "gear_tip_edge_radius_mm": 0.0,
    }  # fmt: skip
    scene = shipped.replace({f"gear_pair.{name}": value for name, value in changes.items()})
    pair = FaceGearMesh(scene.gear_pair, Placement())
    face = np.array([480.05, 481.2, 482.0, 482.6, 520.0, 556.0, 557.0, 557.9])
    rounded, sharp = (trace_contact_lines(pair, ROLLS[2:3], face, sharp=sharp) for sharp in (False, True))
    np.testing.assert_allclose(rounded.profile, sharp.profile, atol=1e-9)
    fallen = rounded.separation[0, 0, 1:] - sharp.separation[0, 0, 1:]
    met = pair.meeting(face, sharp.profile[0], ROLLS[2]).driving_face
    pinion = end_rounding(np.minimum(met - 481.0, 558.0 - met), 1.5)
    assert np.count_nonzero(pinion[1:] > 1e-3) == 4
    np.testing.assert_allclose(fallen, pinion[1:], atol=1e-6)
    assert np.isinf(rounded.separation[0, 0, 0])


def test_every_other_line_keeps_all_slices(traced: Traced) -> None:
    some = traced.lines.every(2)
    np.testing.assert_array_equal(some.roll, ROLLS[::2])
    np.testing.assert_array_equal(some.face, traced.lines.face)
    np.testing.assert_array_equal(some.separation, traced.lines.separation[:, ::2])
    np.testing.assert_array_equal(some.sliding, traced.lines.sliding[::2])


def test_a_rounded_end_is_an_arc() -> None:
    radius, turn = 0.4, np.linspace(0.0, 0.5 * np.pi, 7)
    found = end_rounding(radius * (1.0 - np.sin(turn)), radius)
    np.testing.assert_allclose(found, radius * (1.0 - np.cos(turn)), atol=1e-12)
    np.testing.assert_array_equal(end_rounding(np.array([0.4, 9.0, -1e-9]), radius), [0.0, 0.0, np.inf])


def test_changes_are_not_taken_across_bends() -> None:
    face = np.array([0.0, 1.0, 3.0, 4.0, 6.0, 7.0, 9.0, 10.0])
    side = np.array([-1, -1, -1, 0, 0, 0, 1, 1])
    low, high = np.zeros((1, 8)), np.ones((1, 8))
    profile = (0.5 + 0.5 * side)[None]
    slopes = np.array([2.0, -5.0, 0.5])[side + 1]
    found = change_along_line((slopes * face + 10.0 * side)[None, :, None], face, profile, low, high)
    np.testing.assert_allclose(found[0, :, 0], slopes, atol=1e-12)
    assert not change_along_line(np.ones((2, 1, 3)), face[:1], low[:, :1], low[:, :1], high[:, :1]).any()
