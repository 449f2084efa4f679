"""Contact of elastic bodies: mortar, condensation and active set combined for any number of surface pairs.

`condense` does the part that depends on the meshes alone and `CondensedContact.solve` the rest, in milliseconds:
other torques and wear depths on the same meshes cost little. `solve_contact` does both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from scipy.sparse import csr_matrix, hstack

from fem_reference.active_set import solve_complementarity
from fem_reference.arrays import BoolArray, FloatArray, IntArray
from fem_reference.condensation import SupportedBody
from fem_reference.mortar import Field, Mortar, couple
from fem_reference.surface import Surface
from semiwear.errors import SceneError, SemiwearError

FULL_COVER = 0.98
"""Covered fraction of the facets about a node above which it does not overhang the other surface."""


class ContactMeshError(SemiwearError, RuntimeError):
    """A contact that its mesh cannot resolve: it reaches the end of the candidates, or too few nodes span it."""


@dataclass(frozen=True)
class ContactPair:
    """Two surfaces that may come into contact.

    Attributes
    ----------
    slave : Surface
        Carries the pressures: deformable, and the finer one where it matters.
    master : Surface
    gap : function, array or None [mm]
        Distance along the normal before loading, wear included, as values at all nodes of the slave body or as a
        function of (q, 3) positions on its facets (see `Mortar.average`); None takes the distance of the meshes.
    lever : function, array or float [mm]
        Closing of the gap per unit rotation; the default 1 makes the rotation an approach and the torque a force.
    normals : (n, 3) array, optional
        Unit normals at all nodes of the slave body, outward.
    reach : float, optional [mm]
        Greatest distance of facets that are tried.
    name : str
    """

    slave: Surface
    master: Surface
    gap: Field | None = None
    lever: Field = 1.0
    normals: FloatArray | None = None
    reach: float | None = None
    name: str = "pair"


@dataclass(frozen=True)
class PairContact:
    """Contact of one pair; arrays have one entry per slave node of its mortar.

    Attributes
    ----------
    name : str
    nodes : (k,) int array
        Nodes of the slave body.
    pressure : (k,) array [MPa]
        Force over area; for nodes more than half beyond the master together with their neighbours.
    force : (k,) array [N]
        Presses the slave along minus its normal.
    gap : (k,) array [mm]
        After loading.
    active : (k,) bool array
    on_edge : (k,) bool array
        On a real edge of the slave, or over the border of the master.
    nodes_across : int
        Nodes in contact where the contact is widest, in the direction with the fewest.
    borders : tuple of str
        Borders that the contact reaches: ``"<body>: candidates"`` where the candidates end but the body goes on.
    edges : tuple of str
        Real edges that carry load, as ``"<body>: <name>"``; the pressure there depends on the mesh.
    """

    name: str
    nodes: IntArray
    pressure: FloatArray
    force: FloatArray
    gap: FloatArray
    active: BoolArray
    on_edge: BoolArray
    nodes_across: int
    borders: tuple[str, ...]
    edges: tuple[str, ...]

    @property
    def load(self) -> float:
        """Sum of the forces [N]."""
        return float(self.force.sum())

    @property
    def peak_pressure(self) -> float:
        """Greatest nodal pressure [MPa], at edges too."""
        return float(self.pressure.max())

    @property
    def resolved(self) -> bool:
        """Whether no contact, or at least three nodes across it."""
        return not self.active.any() or self.nodes_across >= 3


@dataclass(frozen=True)
class ContactSolution:
    """Contact of all pairs under one torque.

    Attributes
    ----------
    pairs : tuple of PairContact
    rotation : float [rad, or mm when the lever is 1]
    torque : float [N mm, or N]
    equilibrium_residual : float
        Relative to the torque.
    smallest_gap : float [mm]
        After loading; below zero is penetration.
    iterations : int
        Active sets tried.
    displacement : dict of body to (n, 3) array [mm]
        Of all nodes, when asked for.
    seconds : dict
        Time by stage [s]: mortar, factor, compliance, active_set, displacement.
    sizes : dict
        Candidate nodes, and unknowns of each body.
    """

    pairs: tuple[PairContact, ...]
    rotation: float
    torque: float
    equilibrium_residual: float
    smallest_gap: float
    iterations: int
    displacement: dict[str, FloatArray]
    seconds: dict[str, float]
    sizes: dict[str, int]

    @property
    def problems(self) -> tuple[str, ...]:
        """Messages on unreliable pressures of the loaded pairs; empty if there are none."""
        return self._problems(0.0)

    def _problems(self, least_share: float) -> tuple[str, ...]:
        found = [
            f"{pair.name}: contact reaches the border '{border}'; widen the refined area there or move it along"
            for pair in self.pairs
            for border in pair.borders
        ]
        least = least_share * sum(pair.load for pair in self.pairs)
        found += [
            f"{pair.name}: {pair.nodes_across} node(s) across the contact, needs 3 (7 for 1 % of the peak pressure); "
            "refine the slave surface across it (elements_per_half_width of a gear scene)"
            for pair in self.pairs
            if not pair.resolved and pair.load > least
        ]
        return tuple(found)

    def require_resolved(self, least_share: float = 0.0) -> ContactSolution:
        """The solution itself, checked.

        Parameters
        ----------
        least_share : float
            Share of the load of pairs that may stay unresolved.

        Raises
        ------
        ContactMeshError
            When there are `problems`.
        """
        if problems := self._problems(least_share):
            raise ContactMeshError("\n".join(problems))
        return self


@dataclass(frozen=True)
class CondensedContact:
    """Pairs of surfaces and the compliance of all their slave nodes together.

    Attributes
    ----------
    bodies : mapping of str to SupportedBody
    pairs : tuple of ContactPair
    mortars : tuple of Mortar
    unit_loads : dict of body to (3 n, k) sparse array
        Loads on each body for unit forces of all slave nodes, pair after pair.
    compliance : (k, k) array [mm/N]
    seconds : dict
    """

    bodies: Mapping[str, SupportedBody]
    pairs: tuple[ContactPair, ...]
    mortars: tuple[Mortar, ...]
    unit_loads: dict[str, csr_matrix]
    compliance: FloatArray
    seconds: dict[str, float]

    def solve(
        self,
        torque: float,
        *,
        gaps: Sequence[Field | None] | None = None,
        start: Sequence[BoolArray] | None = None,
        displacements: bool = False,
    ) -> ContactSolution:
        """Contact under a torque.

        Parameters
        ----------
        torque : float [N mm, or N when the levers are 1]
        gaps : sequence, optional
            Instead of those of the pairs.
        start : sequence of bool arrays, optional
            `PairContact.active` of a nearby solution.
        displacements : bool
            Whether to work out the displacement of all nodes of all bodies.
        """
        gaps = [pair.gap for pair in self.pairs] if gaps is None else gaps
        started = perf_counter()
        opening = [m.distance if gap is None else m.average(gap) for m, gap in zip(self.mortars, gaps, strict=True)]
        solution = solve_complementarity(
            self.compliance,
            np.concatenate(opening),
            np.concatenate([m.average(pair.lever) for m, pair in zip(self.mortars, self.pairs, strict=True)]),
            torque,
            start=None if start is None else np.concatenate(list(start)),
        )
        solved = perf_counter()
        moved = {}
        if displacements:
            for name, body in self.bodies.items():
                moved[name] = body.displacement(self.unit_loads[name] @ solution.force).reshape(-1, 3)
        seconds = self.seconds | {"active_set": solved - started, "displacement": perf_counter() - solved}
        ends = np.cumsum([len(mortar.nodes) for mortar in self.mortars])[:-1]
        parts = zip(*(np.split(x, ends) for x in (solution.force, solution.gap, solution.active)), strict=True)
        sizes = {"candidates": len(solution.force)} | {name: body.size for name, body in self.bodies.items()}
        return ContactSolution(
            pairs=tuple(_report(p, m, *part) for p, m, part in zip(self.pairs, self.mortars, parts, strict=True)),
            rotation=solution.rotation,
            torque=torque,
            equilibrium_residual=solution.equilibrium_residual,
            smallest_gap=float(solution.gap.min()),
            iterations=solution.iterations,
            displacement=moved,
            seconds=seconds,
            sizes=sizes,
        )


def condense(bodies: Mapping[str, SupportedBody], pairs: Sequence[ContactPair]) -> CondensedContact:
    """Couple the surfaces and condense the bodies onto their slave nodes.

    Parameters
    ----------
    bodies : mapping of str to SupportedBody
    pairs : sequence of ContactPair
        Pairs that share bodies are coupled. A surface with body None is rigid.
    """
    for surface in (surface for pair in pairs for surface in (pair.slave, pair.master)):
        if surface.body is not None and surface.body not in bodies:
            raise SceneError.of("surface.body", surface.body, f"one of {', '.join(bodies)}, or None for a rigid one")
    started = perf_counter()
    mortars = tuple(couple(p.slave, p.master, normals=p.normals, reach=p.reach) for p in pairs)
    seconds = {"mortar": perf_counter() - started, "factor": 0.0, "compliance": 0.0}
    for name in bodies:
        slaves = [np.unique(m.shares.indices) for p, m in zip(pairs, mortars, strict=True) if p.slave.body == name]
        place, times = np.unique(np.concatenate([*slaves, np.empty(0, dtype=np.int64)]), return_counts=True)
        if (times > 1).any():
            raise SceneError.of(
                "pairs", f"node {place[times > 1][0]} of {name} in two pairs", "each slave node in one pair",
                "take the facets about it out of one of the slave surfaces",
            )  # fmt: skip
    loads = [mortar.unit_loads() for mortar in mortars]
    count = sum(len(mortar.nodes) for mortar in mortars)
    compliance = np.zeros((count, count))
    unit_loads = {}
    for name, body in bodies.items():
        blocks = []
        for pair, mortar, (on_slave, on_master) in zip(pairs, mortars, loads, strict=True):
            block = csr_matrix((body.size, len(mortar.nodes)))
            if pair.slave.body == name:
                block = block + on_slave
            if pair.master.body == name:
                block = block + on_master
            blocks.append(block)
        unit_loads[name] = csr_matrix(hstack(blocks))
        spent = dict(body.seconds)
        compliance += body.compliance(unit_loads[name])
        for stage in ("factor", "compliance"):
            seconds[stage] += body.seconds[stage] - spent[stage]
    return CondensedContact(bodies, tuple(pairs), mortars, unit_loads, compliance, seconds)


def solve_contact(
    bodies: Mapping[str, SupportedBody], pairs: Sequence[ContactPair], torque: float, *, displacements: bool = False
) -> ContactSolution:
    """Contact of elastic bodies under a torque: `condense`, then `CondensedContact.solve`.

    Parameters
    ----------
    bodies : mapping of str to SupportedBody
    pairs : sequence of ContactPair
    torque : float [N mm, or N when the levers are 1]
    displacements : bool
        Whether to work out the displacement of all nodes of all bodies.
    """
    return condense(bodies, pairs).solve(torque, displacements=displacements)


def _report(pair: ContactPair, mortar: Mortar, force: FloatArray, gap: FloatArray, active: BoolArray) -> PairContact:
    """Contact of a pair, with the borders and edges that it reaches."""
    touching = mortar.nodes[active]
    # a slave node that overhangs the border of the master is coupled to the nodes there
    hanging = mortar.covered < FULL_COVER
    seen = np.unique(mortar.transfer[active & hanging].indices)
    names = [
        f"{surface.body or 'rigid'}: {name}"
        for surface, reached in ((pair.slave, touching), (pair.master, seen))
        for name, nodes in surface.border.items()
        if np.isin(reached, nodes).any()
    ]
    real_edges = [nodes for name, nodes in pair.slave.border.items() if name != "candidates"]
    return PairContact(
        name=pair.name,
        nodes=mortar.nodes,
        pressure=mortar.pressure(force),
        force=force,
        gap=gap,
        active=active,
        on_edge=hanging | np.isin(mortar.nodes, np.concatenate([*real_edges, np.empty(0, dtype=np.int64)])),
        nodes_across=_nodes_across(pair.slave, touching),
        borders=tuple(name for name in names if name.endswith(": candidates")),
        edges=tuple(name for name in names if not name.endswith(": candidates")),
    )


def _nodes_across(surface: Surface, touching: IntArray) -> int:
    """Nodes across a contact: remove the nodes beside a free one until none remains; each layer counts as two."""
    across, inside = 0, np.zeros(len(surface.points))
    inside[touching] = 1.0
    beside = surface.neighbours.astype(bool).astype(float)
    while inside.any():
        across += 2
        kept = inside * (beside @ (1.0 - inside) == 0.0)
        if (kept == inside).all():  # the contact covers the surface
            return len(touching)
        inside = kept
    return max(across - 1, 0)
