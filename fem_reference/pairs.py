"""From a scene to its pair in motion and its meshes: the only module here that distinguishes kinds of gear pair."""

from __future__ import annotations

from collections.abc import Mapping

from fem_reference.cylindrical_mesh import CylindricalSurface, cylindrical_mesh
from fem_reference.cylindrical_motion import CylindricalMotion
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.kinematics import PairKinematics
from fem_reference.pair_motion import PairMotion
from fem_reference.pinion_mesh import pinion_mesh
from fem_reference.tooth_mesh import Divisions, Refinement, ToothMesh
from semiwear.errors import SceneError
from semiwear.scene import CylindricalPair, FaceGearPair, Placement, Scene


def _refused(scene: Scene) -> SceneError:
    return SceneError.of(
        "gear_pair.type", scene.gear_pair.type, '"face_gear" or "cylindrical"',
        "finite elements mesh teeth that are known in closed form; for flanks given as points use the core",
    )  # fmt: skip


def pair_motion(scene: Scene, placement: Placement | None = None) -> PairMotion:
    """The scene's pair in motion.

    Raises
    ------
    SceneError
        For a kind that these finite elements do not mesh.
    """
    if isinstance(scene.gear_pair, CylindricalPair):
        return CylindricalMotion(scene, placement or Placement())
    if isinstance(scene.gear_pair, FaceGearPair):
        return PairKinematics(scene, placement or Placement())
    raise _refused(scene)


def module_of(scene: Scene) -> float:
    """Module, normal to the teeth [mm]."""
    pair = scene.gear_pair
    if isinstance(pair, CylindricalPair):
        return pair.normal_module_mm
    if isinstance(pair, FaceGearPair):
        return pair.module_mm
    raise _refused(scene)


def usual_teeth(scene: Scene) -> dict[str, int | None]:
    """Default number of teeth in the mesh of each body; None is every tooth.

    A sector of a thick ring is far less stiff than the ring, the more so the thicker it is, and no number of teeth
    suffices for all bodies: cylindrical pairs are meshed with every tooth. The face gear's teeth stand on a held back
    face.
    """
    whole = isinstance(scene.gear_pair, CylindricalPair)
    return {"pinion": None, "gear": None} if whole else {"pinion": 9, "gear": 5}


def body_mesh(
    scene: Scene,
    body: str,
    *,
    element: str = "hex8i",
    teeth: int | None = 5,
    refinements: Mapping[int, Refinement] | None = None,
    divisions: Divisions | None = None,
    detailed: tuple[int, ...] = (0,),
    explicit: int | None = None,
) -> ToothMesh:
    """Mesh a stretch of a body, ``"pinion"`` or ``"gear"``, in its own frame; arguments as for `face_gear_mesh`.

    Of a cylindrical gear `teeth` may be None, the whole ring, with `explicit` as for `cylindrical_mesh`.
    """
    if body not in ("pinion", "gear"):
        raise ValueError(f"body must be 'pinion' or 'gear', not {body!r}")
    motion = pair_motion(scene)
    if isinstance(motion, CylindricalMotion):
        limits = motion.pinion_face if body == "pinion" else motion.gear_face
        surface = CylindricalSurface(motion.pinion if body == "pinion" else motion.gear, limits, body)
        return cylindrical_mesh(
            surface, module=module_of(scene), element=element, teeth=teeth, refinements=refinements,
            divisions=divisions, detailed=detailed, explicit=explicit,
        )  # fmt: skip
    mesh = pinion_mesh if body == "pinion" else face_gear_mesh
    if teeth is None:
        raise ValueError(f"{body}: give the number of teeth of a face gear pair to be meshed")
    return mesh(scene, element=element, teeth=teeth, refinements=refinements, divisions=divisions, detailed=detailed)
