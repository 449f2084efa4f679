"""CalculiX as an outside referee: ``python -m validation.calculix``.

Writes decks, runs ``ccx`` on them and compares with our own solution:

* a loaded face-gear tooth between unloaded neighbours, C3D20 against our "hex20" on the same mesh: deflection of the
  tip and greatest tangential stress of the fillet;
* both bodies of a helical pair (20/31, 30 degrees, thick bodies, every tooth) under the forces of its contact
  solution: deflection where the forces act and root stress, C3D20 against our "hex20" on the same mesh;
* a Hertz contact, a cylinder on a block, C3D8I with surface-to-surface contact: greatest pressure and half-width
  against the closed form for the force that ccx finds.

``ccx`` is taken from the environment variable CCX, else from PATH (Debian: apt-get install calculix-ccx).
Exit status: 0 all within tolerance, 1 a difference is too great or ccx failed, 2 ccx is missing.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from skfem import MeshHex

from fem_reference.abaqus import ContactPair, write_inp
from fem_reference.elasticity import ElasticBody
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.loaded import mesh_and_solve, torque_of
from fem_reference.mesh_position import MeshSettings
from fem_reference.pairs import pair_motion
from fem_reference.rigid_lines import RigidFlank
from fem_reference.root_load import BODIES, RootStress
from fem_reference.root_stress import ROOT_FROM, fillet_stress, pressure_load
from fem_reference.solvers import factorise
from fem_reference.tooth_mesh import LOADED, Divisions, FilletGrid
from semiwear.arrays import FloatArray
from semiwear.scene import Scene, load_scene
from validation.helical_pairs import helical_scene


class CalculixError(RuntimeError):
    """ccx is missing or did not finish; the message holds the end of its log."""


@dataclass(frozen=True)
class Comparison:
    """One quantity as CalculiX and as the other source have it.

    Attributes
    ----------
    name : str
    ours, calculix : float
    tolerance : float
        Allowed relative difference.
    unit : str
    """

    name: str
    ours: float
    calculix: float
    tolerance: float
    unit: str

    @property
    def difference(self) -> float:
        """CalculiX relative to ours."""
        return self.calculix / self.ours - 1.0

    @property
    def passed(self) -> bool:
        """Whether both agree within the tolerance."""
        return abs(self.difference) <= self.tolerance


def find_ccx() -> str:
    """Path of the ccx executable.

    Raises
    ------
    CalculixError
        When there is none.
    """
    named = os.environ.get("CCX")
    found = shutil.which(named) if named else shutil.which("ccx") or shutil.which("ccx_2.20")
    if found is None:
        where = f"CCX={named}" if named else "ccx is not on PATH"
        raise CalculixError(f"CalculiX not found ({where}); apt-get install calculix-ccx, or set CCX to its path")
    return found


def run(deck: Path, *, ccx: str | None = None, timeout: float = 600.0) -> None:
    """Run ccx on a deck; a log without "Job finished" is a failure, whatever the exit status says.

    Raises
    ------
    CalculixError
    """
    log = subprocess.run(
        [ccx or find_ccx(), deck.stem], cwd=deck.parent, capture_output=True, text=True, timeout=timeout, check=False
    )
    if "Job finished" not in log.stdout:
        tail = "\n".join((log.stdout + log.stderr).splitlines()[-15:])
        raise CalculixError(f"ccx did not finish {deck.name} (exit status {log.returncode}):\n{tail}")


def read_frd(path: Path) -> dict[str, dict[int, FloatArray]]:
    """Nodal results of the last increment in an ASCII .frd file: block name -> node -> components."""
    blocks: dict[str, dict[int, FloatArray]] = {}
    current: dict[int, FloatArray] | None = None
    for line in path.read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith(" -4"):
            current = blocks[line.split()[1]] = {}
        elif line.startswith(" -3"):
            current = None
        elif line.startswith(" -1") and current is not None:
            values = [float(line[k : k + 12]) for k in range(13, len(line.rstrip()), 12)]
            current[int(line[3:13])] = np.array(values)
    return blocks


def read_total_force(path: Path) -> FloatArray:
    """Last total reaction in a .dat file [N]."""
    lines = path.read_text(encoding="ascii", errors="replace").splitlines()
    heads = [k for k, line in enumerate(lines) if line.strip().startswith("total force")]
    return np.array([float(value) for value in lines[heads[-1] + 2].split()])


def tooth(folder: Path, *, scene: Scene | None = None, divisions: Divisions | None = None) -> list[Comparison]:
    """A pressure on one face-gear tooth: tip deflection and root stress on the same 20-node mesh."""
    scene = scene or load_scene("face_gear_25x160")
    pair, material = scene.gear_pair, scene.material.gear
    divisions = divisions or Divisions(flank=8, fillet=8, land=1, across=6, depth=8, face_size=pair.module_mm)
    mesh = face_gear_mesh(scene, element="hex20", teeth=3, divisions=divisions)
    body = ElasticBody.of(mesh.mesh, "hex20", material)
    module, middle = pair.module_mm, pair.gear_pitch_radius_mm

    def pressure(profile: FloatArray, face: FloatArray) -> FloatArray:
        return 200.0 * np.exp(-((profile / (0.25 * module)) ** 2) - ((face - middle) / (3.0 * module)) ** 2)

    load = pressure_load(body, mesh, pressure)
    free = body.free_dofs(mesh.held)
    displacement = np.zeros(body.points.size)
    displacement[free] = factorise(body.stiffness[free][:, free], places=body.points[free // 3]).solve(load[free])

    deck = folder / "tooth.inp"
    write_inp(
        deck,
        {"gear": body},
        node_sets={"back": ("gear", mesh.held)},
        boundary=[("back", 1, 3, 0.0)],
        forces={"gear": load},
        title="semiwear: face gear tooth under pressure",
    )
    run(deck)
    results = read_frd(deck.with_suffix(".frd"))
    theirs = np.array([results["DISP"][node + 1][:3] for node in range(len(body.points))])
    flank = mesh.flanks[0, LOADED]
    station = 2 * int(np.argmin(np.abs(flank.face[::2] - middle)))
    tip, normal = flank.nodes[-1, station], flank.normals[-1, station]

    # their own stress: extrapolated to the nodes and averaged by ccx, along the fillet; ours recovered alike
    fillet = mesh.fillets[0, LOADED]
    nodes, tangent = fillet.nodes[:, ::2], fillet.tangents[:, ::2]
    own = body.stress(displacement, nodes=nodes.ravel()).reshape(*nodes.shape, 6)
    frd = np.array([[results["STRESS"][int(node) + 1] for node in row] for row in nodes])
    ours_nodal, their_nodal = (float(_along(stress, tangent).max()) for stress in (own, frd))
    gauges = fillet_stress(body, mesh, displacement).greatest
    their_gauges = fillet_stress(body, mesh, theirs.ravel()).greatest
    return [
        Comparison("tip deflection", *(1e3 * float(-u[tip] @ normal) for u in (displacement.reshape(-1, 3), theirs)),
                   0.001, "um"),
        Comparison("root stress at nodes, ccx recovery", ours_nodal, their_nodal, 0.02, "MPa"),
        Comparison("root stress, our gauges on ccx motion", gauges, their_gauges, 0.002, "MPa"),
        Comparison("root stress, ccx nodes, our gauges", gauges, their_nodal, 0.02, "MPa"),
    ]  # fmt: skip


def _along(stress: FloatArray, tangent: FloatArray) -> FloatArray:
    """Component along a direction of six-component stress (xx, yy, zz, xy, yz, zx)."""
    x, y, z = np.moveaxis(tangent, -1, 0)
    weights = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * z * x], axis=-1)
    return np.sum(weights * stress, axis=-1)


def helical(
    folder: Path, *, scene: Scene | None = None, fillet: int = 6, face_size: float = 1.25
) -> list[Comparison]:
    """Both bodies of a helical pair with every tooth meshed, under the forces of its own contact solution.

    Deflection is the motion of the points where the forces act, along them, weighted by them: what the bodies add to
    the approach of the pair, hence to its transmission error.
    """
    scene = scene or helical_scene(30.0, 30.0, "thick")
    flank = RigidFlank(pair_motion(scene))
    width = flank.pair.gear_face[1] - flank.pair.gear_face[0]
    settings = MeshSettings(1.0, width / 8.0, gear_teeth=None, pinion_teeth=None)
    meshed, result = mesh_and_solve(flank, 0.0, settings, torque_of(flank))
    total = sum(found.contact.load for found in result.pairs.values())
    busiest = max(result.pairs, key=lambda j: result.pairs[j].contact.load)
    teeth = {name: abs(getattr(scene.gear_pair, f"{name}_teeth")) for name in BODIES}
    roots = RootStress(
        scene, teeth["gear"], teeth["pinion"], fillet=fillet, across=fillet - 2, flank=fillet, face_size=face_size
    )
    found = []
    for name in BODIES:
        body, supported = roots.systems[name]
        mesh, load = roots.meshes[name], roots.forces(name, busiest, result.pairs, meshed.poses[name])
        displacement = supported.displacement(load)
        deck = folder / f"helical_{name}.inp"
        write_inp(
            deck,
            {name: body},
            node_sets={"bore": (name, mesh.held)},
            boundary=[("bore", 1, 3, 0.0)],
            forces={name: load},
            title=f"semiwear: {name} of a helical pair under its contact forces",
        )
        run(deck, timeout=7200.0)
        results = read_frd(deck.with_suffix(".frd"))
        theirs = np.array([results["DISP"][node + 1][:3] for node in range(len(body.points))]).ravel()
        grid = mesh.fillets[0, LOADED]
        fillet_nodes, tangent = grid.nodes[:, ::2], _normal_to_the_tooth(grid)[:, ::2]
        # from where root stress counts, clear of the stress of the contact itself
        counts = mesh.fillets[0, LOADED].arc[:, ::2]
        counts = counts >= ROOT_FROM * counts[-1]
        frd = np.array([[results["STRESS"][int(node) + 1] for node in row] for row in fillet_nodes])
        gauges = fillet_stress(body, mesh, displacement).greatest
        found += [
            Comparison(f"{name}: deflection under its forces",
                       *(1e3 * float(load @ moved) / total for moved in (displacement, theirs)), 0.02, "um"),
            Comparison(f"{name}: root stress, our gauges on ccx motion", gauges,
                       fillet_stress(body, mesh, theirs).greatest, 0.02, "MPa"),
            Comparison(f"{name}: root stress, ccx nodes, our gauges", gauges,
                       float(_along(frd, tangent)[counts].max()), 0.02, "MPa"),
        ]  # fmt: skip
    return found


def _normal_to_the_tooth(fillet: FilletGrid) -> np.ndarray:
    """Unit tangents (arc, face, 3) of the fillet's surface, across the lines that follow the tooth."""
    down, along = fillet.tangents, np.gradient(fillet.points, fillet.face, axis=1)
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    across = down - np.einsum("afi,afi->af", down, along)[:, :, None] * along
    return across / np.linalg.norm(across, axis=2, keepdims=True)


def hertz(folder: Path, *, elements_per_half_width: int = 4) -> list[Comparison]:
    """A slice of a cylinder pressed on a block, displacement control, against the closed form (Johnson, ch. 4).

    Plane strain by holding the slice's sides; half of the symmetric pair. The approach of a plane contact depends on
    the blocks, so the force that ccx finds gives the Hertz pressure to compare with.
    """
    radius, half_width, width = 20.0, 0.4, 0.5
    modulus, poisson = 207000.0, 0.3
    size = half_width / elements_per_half_width
    across = np.concatenate([np.arange(0.0, 2.0 * half_width + 1e-9, size), np.geomspace(1.15, 8.0, 9)])
    down = np.concatenate([[0.0], np.cumsum(size * 1.3 ** np.arange(14))])
    down = down * 8.0 / down[-1]
    block = MeshHex.init_tensor(across, -down[::-1], np.array([0.0, width]))
    top = MeshHex.init_tensor(across, down, np.array([0.0, width]))
    lift = across**2 / (2.0 * radius)
    raised = top.p.copy()
    raised[1] += np.interp(top.p[0], across, lift) * (1.0 - top.p[1] / 8.0)
    bodies = {
        name: ElasticBody(mesh, youngs_modulus=modulus, poissons_ratio=poisson)
        for name, mesh in (("block", block), ("cylinder", MeshHex(raised, top.t)))
    }
    low, high = (body.points for body in bodies.values())
    sets = {
        "foot": ("block", np.flatnonzero(low[:, 1] < -8.0 + 1e-9)),
        "head": ("cylinder", np.flatnonzero(high[:, 1] > 8.0 - 1e-9)),
    }
    for name, points in (("block", low), ("cylinder", high)):
        sets[f"{name}middle"] = (name, np.flatnonzero(points[:, 0] < 1e-9))
        sets[f"{name}sides"] = (name, np.arange(len(points)))
    effective = modulus / (2.0 * (1.0 - poisson**2))
    line_load = np.pi * effective * half_width**2 / (4.0 * radius)
    # approach of two blocks of depth h under a line load (Johnson, eq. 5.58, each block): a first guess only
    approach = (
        2.0 * line_load * (1.0 - poisson**2) / (np.pi * modulus) * (2.0 * np.log(2.0 * 8.0 / half_width) - 0.43)
    )
    deck = folder / "hertz.inp"
    write_inp(
        deck,
        bodies,
        node_sets=sets,
        surfaces={
            "upper": ("cylinder", np.flatnonzero(top.p[1] < 1e-9)),
            "lower": ("block", np.flatnonzero(low[:, 1] > -1e-9)),
        },
        boundary=[
            ("foot", 1, 2, 0.0),
            ("head", 1, 1, 0.0),
            ("head", 2, 2, -approach),
            *((f"{name}middle", 1, 1, 0.0) for name in bodies),
            *((f"{name}sides", 3, 3, 0.0) for name in bodies),
        ],
        contacts=[ContactPair("upper", "lower")],
        increment=0.2,
        reactions=["foot"],
        title="semiwear: cylinder on a block",
    )
    run(deck)
    contact = read_frd(deck.with_suffix(".frd"))["CONTACT"]
    force = 2.0 * abs(read_total_force(deck.with_suffix(".dat"))[1]) / width
    found_half_width = np.sqrt(4.0 * force * radius / (np.pi * effective))
    pressure = max(float(values[3]) for values in contact.values())
    loaded = [node for node, values in contact.items() if values[3] > 0.0]
    first = len(low) + 1
    edge = max(high[node - first, 0] for node in loaded if node >= first)
    return [
        Comparison("Hertz: greatest pressure", 2.0 * force / (np.pi * found_half_width), pressure, 0.02, "MPa"),
        Comparison("Hertz: half-width", float(found_half_width), float(edge), 1.2 / elements_per_half_width, "mm"),
    ]


def main() -> int:
    """Run all problems and print a table."""
    try:
        find_ccx()
    except CalculixError as reason:
        print(reason, file=sys.stderr)
        return 2
    passed = True
    print(f"{'quantity':44s} {'ours':>12s} {'CalculiX':>12s} {'difference':>11s} {'allowed':>8s}")
    for problem in (tooth, helical, hertz):
        try:
            with tempfile.TemporaryDirectory() as folder:
                comparisons = problem(Path(folder))
        except CalculixError as reason:
            print(f"{problem.__name__}: {reason}", file=sys.stderr)
            passed = False
            continue
        for c in comparisons:
            mark = "" if c.passed else "  <-- too much"
            values = f"{c.ours:12.5g} {c.calculix:12.5g} {c.difference:+10.2%} {c.tolerance:8.2%}"
            print(f"{c.name:44s} {values} {c.unit}{mark}")
            passed &= c.passed
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
