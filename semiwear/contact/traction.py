"""Friction force of a slice that rolls and slides: its fraction of mu q where sliding nearly vanishes.

Coulomb's law alone has no value where sliding is zero, and the friction force would jump there from -mu q to mu q. A
contact of finite width does not. At an instant the flanks slide alike across it (to the first order, the difference
of two rigid velocities changes along the common normal only), but their surfaces stretch, and where they stretch by
as much as they would slide, they stick. For two elastic cylinders in steady rolling (Carter 1926; Johnson 1985,
section 8.3) a band at the side where points enter sticks until the creep ratio is mu b/R, and

    Q/(mu q) = 1 - (1 - c)^2,   c = |v_s|/v_full < 1,   v_full = mu (b/R) |v_1 + v_2|/2,

Q along the sliding velocity, 1 beyond. For involutes on parallel axes c is the distance of the contact from the pitch
point along the line of action over mu b. The law is odd and continuous; where sliding has a component along the line
as well, it is taken for the whole vector. Neglected: sideways traction yields by 1/(1 - nu) more; where axes cross,
spin turns the sliding velocity across the width of the slice at the pitch point; and a reversal is quasi-steady here,
while points take 2b of rolling to pass through, so that in truth it lags behind by about that much.

Sources: Carter, F. W. 1926, On the action of a locomotive driving wheel, Proc. R. Soc. Lond. A 112, 151-157; Johnson,
K. L. 1985, Contact Mechanics, Cambridge University Press, section 8.3.
"""

from __future__ import annotations

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.conditions import ContactConditions


def full_sliding_speed(conditions: ContactConditions, friction: FloatArray) -> FloatArray:
    """Sliding speed from which no part of a contact sticks: mu b/R times the rolling speed [mm/s].

    Parameters
    ----------
    conditions : ContactConditions
    friction : (roll, face) array
        Coefficient of friction.
    """
    return friction * conditions.half_width * conditions.curvature * conditions.entraining_speed


def share_of_full_friction(speed: FloatArray, full: FloatArray) -> FloatArray:
    """Friction force over mu q at a sliding speed, in [0, 1].

    Parameters
    ----------
    speed : array [mm/s]
        Magnitude of the sliding velocity.
    full : array [mm/s]
        `full_sliding_speed`; 0 for rigid surfaces.
    """
    return share_per_speed(speed, full) * speed


def share_per_speed(speed: FloatArray, full: FloatArray) -> FloatArray:
    """`share_of_full_friction` over the speed [s/mm]: times the sliding velocity it is the friction force over mu q.

    It has a value where the speed vanishes, 2/`full`, and is 0 where rigid surfaces do not slide.
    """
    speed, full = np.broadcast_arrays(speed, full)
    sticks = speed < full
    sliding = np.where(speed > 0.0, speed, np.inf)
    return np.where(sticks, (2.0 - speed / np.where(sticks, full, 1.0)) / np.where(sticks, full, 1.0), 1.0 / sliding)
