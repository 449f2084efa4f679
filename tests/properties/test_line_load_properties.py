"""What a reader integrates: line loads over the lengths that are stored with them are forces and moments."""

from math import cos, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import semiwear as sw
from semiwear.meshing.contact_lines import face_stations, trace_contact_lines
from semiwear.plan import plan

SPUR = sw.load_scene("spur_fzg_c").replace(
    {
        "wear": None,
        "gear_pair.centre_distance_mm": None,
        "numerics.roll_positions": 8,
        "numerics.harmonics": 3,
        "numerics.profile_points": 41,
        "numerics.tooth_compliance": "rigid",  # how loads spread is no matter, and an inclined wheel takes its time
    }
)
few = settings(max_examples=max(settings.default.max_examples // 3, 4), suppress_health_check=[HealthCheck.too_slow])


@st.composite
def helical(draw: st.DrawFn) -> sw.Scene:
    """Pairs of any helix angle on grids that are often coarse."""
    return SPUR.replace(
        {
            "gear_pair.helix_angle_deg": draw(st.floats(0.0, 35.0)),
            "gear_pair.hand": draw(st.sampled_from(["right", "left"])),
            "gear_pair.pinion_face_width_mm": draw(st.floats(8.0, 60.0)),
            "numerics.face_slices": draw(st.integers(7, 25)),
            "operation.pinion_torque_Nm": draw(st.floats(20.0, 600.0)),
        }
    )


@pytest.mark.slow
@given(helical())
@example(SPUR.replace({"gear_pair.helix_angle_deg": 20.0, "numerics.tooth_compliance": "prism"}))
@few
def test_line_loads_times_lengths_times_levers_are_the_torque(scene):
    engagement = sw.loaded_contact(scene)["engagement"].to_dataset()
    moment = (engagement.line_load * engagement.line_length * engagement.lever_arm).sum("face").values[0]
    torque = 1e3 * scene.operation.pinion_torque_Nm
    by_position = moment.reshape(-1, scene.numerics.roll_positions)
    np.testing.assert_allclose(by_position.sum(axis=0), torque, rtol=1e-9)
    np.testing.assert_allclose(moment / torque, engagement.load_share.values[0], atol=1e-9)


@given(helical())
@few
def test_lengths_are_those_of_lines_on_the_base_helix(scene):
    """Wherever a line runs over both flanks, next to a border as well."""
    pair = plan(scene).flank_pair()
    face = face_stations(pair, scene.numerics.face_slices)
    lines = trace_contact_lines(pair, np.linspace(-1.5, 1.5, 25), face)
    inside = (lines.profile > lines.low) & (lines.profile < lines.high) & np.isfinite(lines.separation[0])
    inside &= lines.separation[0] < 1e-6
    beside = np.zeros_like(inside)
    beside[:, 1:] |= inside[:, :-1]
    beside[:, :-1] |= inside[:, 1:]
    tilt = sin(radians(scene.gear_pair.helix_angle_deg)) * cos(radians(scene.gear_pair.pressure_angle_deg))
    expected = (face[1] - face[0]) / sqrt(1.0 - tilt**2)
    np.testing.assert_allclose(lines.length[inside & beside], expected, rtol=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["line", "patch"])
def test_moments_of_a_face_gear_on_both_fidelities(small, fidelity):
    scene = small.replace({"wear": None, "numerics.fidelity": fidelity, "numerics.harmonics": 5})
    engagement = sw.loaded_contact(scene, [0.0, 0.3])["engagement"].to_dataset()
    moment = (engagement.line_load * engagement.line_length * engagement.lever_arm).sum("face").values[0]
    np.testing.assert_allclose(moment.reshape(-1, 2).sum(axis=0), 1e3 * scene.operation.pinion_torque_Nm, rtol=1e-9)
