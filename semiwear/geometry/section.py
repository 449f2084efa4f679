"""Section of a tooth with its fillet and rim, from which tooth compliance is computed."""

from __future__ import annotations

from dataclasses import dataclass

from semiwear.arrays import FloatArray


@dataclass(frozen=True)
class RackRim:
    """Teeth side by side on a plane rim that is held at its back face.

    Attributes
    ----------
    pitch : float
        Distance between neighbouring teeth [mm].
    back_height : float
        Height coordinate y of the held back face [mm].
    """

    pitch: float
    back_height: float


@dataclass(frozen=True)
class RingRim:
    """A whole ring of teeth that is held at its bore; the ring's centre is the origin of the section.

    Attributes
    ----------
    teeth : float
        Number of teeth of the whole ring; that of a virtual spur gear need not be whole.
    bore_radius : float
        Radius of the held bore [mm].
    """

    teeth: float
    bore_radius: float


@dataclass(frozen=True)
class ToothSection:
    """Half of a symmetric tooth, x >= 0 from its centre line (the y axis), y rising towards the tip.

    The loaded flank is this half; the other half is its mirror image. From the end of `fillet` the outline
    continues to the middle of the tooth space: straight (same y) for a rack, on the root circle for a ring.

    Attributes
    ----------
    flank : (n, 2) array [mm]
        Outline from the tip corner down to the end of the active flank.
    flank_profile : (n,) array [mm]
        The flank pair's profile coordinate at the points of `flank`, monotonic.
    fillet : (k, 2) array [mm]
        Outline from the end of the flank (same point) to the root.
    rim : RackRim or RingRim
        Rim under the tooth.
    """

    flank: FloatArray
    flank_profile: FloatArray
    fillet: FloatArray
    rim: RackRim | RingRim
