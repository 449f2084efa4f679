"""Load cases under which flanks wear, and the width of the contact of whole flanks under their torques."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.closed_forms.hertz import elliptic_contact, line_contact_half_width
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.tooth_contact import ContactPoints
from semiwear.plan.effects import PitchSequence
from semiwear.scene import Scene
from semiwear.wear.stepping import LoadCase

_FLATTEST = 1e-8  # ratio of principal curvatures: less makes no ellipse that a face could hold


@dataclass(frozen=True)
class WearingTorques:
    """Torques under which the flanks of a scene wear, and how wide whole flanks touch at the pitch point.

    Attributes
    ----------
    scene : Scene
    pair : FlankPair
        As it is placed.
    middle : ContactPoints
        First contact in the middle of the path of contact of the pair without misalignment.
    modulus : float [MPa]
        Effective modulus E*.
    """

    scene: Scene
    pair: FlankPair
    middle: ContactPoints
    modulus: float

    @property
    def torques(self) -> tuple[float, ...]:
        """On the pinion [N m]."""
        spectrum = self.scene.effects.load_spectrum
        return (self.scene.operation.pinion_torque_Nm,) if spectrum is None else spectrum.torques_Nm

    @property
    def shares(self) -> tuple[float, ...]:
        """Of the meshes, by torque."""
        spectrum = self.scene.effects.load_spectrum
        return (1.0,) if spectrum is None else spectrum.shares

    @property
    def mean_over_wear(self) -> float:
        """Mean of the torques over the wear that they cause, which grows with each of them [N m]."""
        return float(np.average(self.torques, weights=self._wear))

    @property
    def mean_half_width(self) -> float:
        """Half-width that spreads as far as those of all torques together [mm].

        Its square is the mean of the squares under all torques, over the wear that each causes: that of their sum.
        """
        widths = [self.half_width(torque) for torque in self.torques]
        return float(np.sqrt(np.average(np.square(widths), weights=self._wear)))

    @property
    def _wear(self) -> FloatArray:
        """Wear by torque, in proportion."""
        return np.multiply(self.torques, self.shares)

    def load(self, torque: float) -> float:
        """Normal load of all teeth under a torque [N]."""
        return 1e3 * torque / float(self.pair.lever_arm(self.middle.position)[0])

    def half_width(self, torque: float) -> float:
        """Hertz half-width of all the load on one pair [mm]: of an ellipse, or of a line if that leaves the face."""
        load, (low, high) = self.load(torque), self.pair.face_limits
        along, across = self.middle.curvature[0].tolist()
        ellipse = elliptic_contact(load, max(along, _FLATTEST * across), across, self.modulus)
        if 2.0 * ellipse.major_half_axis <= high - low:
            return ellipse.minor_half_axis
        return float(line_contact_half_width(np.array(load / (high - low)), np.array(across), self.modulus))


def load_cases(teeth: LoadedTeeth, wearing: WearingTorques, sequences: list[PitchSequence]) -> tuple[LoadCase, ...]:
    """Load cases of the wear: every torque of a spectrum with every sequence of pitch errors; none without either."""
    if wearing.scene.effects.load_spectrum is None and not sequences:
        return ()
    mean = float(np.dot(wearing.torques, wearing.shares))
    following = [(teeth, sequences[0].share if sequences else 1.0)]
    following += [(_with_pitch(teeth, one.gap - sequences[0].gap), one.share) for one in sequences[1:]]
    return tuple(
        LoadCase(
            share * often,
            replace(
                case,
                problem=case.problem.under(np.full(teeth.rolls.phase.size, 1e3 * torque)),
                half_width=wearing.half_width(torque),
            ),
            mean / torque,
        )
        for case, often in following
        for torque, share in zip(wearing.torques, wearing.shares, strict=True)
    )


def pushed_back(lines: ContactLines, offset: FloatArray) -> ContactLines:
    """Lines whose tooth pairs are farther apart by an offset each [mm]."""
    separation = lines.separation.copy()
    separation[0] += np.repeat(offset, lines.roll.size // offset.size)[:, None]
    return replace(lines, separation=separation)


def _with_pitch(teeth: LoadedTeeth, offset: FloatArray) -> LoadedTeeth:
    """The same teeth with tooth pairs pushed back by an offset each [mm]."""
    fine = pushed_back(teeth.fine, offset)
    lines = fine.every(teeth.rolls.substeps)
    return replace(teeth, fine=fine, lines=lines, problem=teeth.problem.on_lines(lines))
