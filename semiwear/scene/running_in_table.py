"""Table of the running in of roughness; exported by `semiwear.scene.effects`."""

from __future__ import annotations

from typing import ClassVar

from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import EffectTable, NeedsIf
from semiwear.scene.rule import above, between, choice
from semiwear.scene.values import number

_LAW, _MODE = "effects.wear_law.lubrication", "effects.micropitting"


@table
class RunningIn(EffectTable):
    """Table ``[effects.running_in]``: the roughness of each flank point decreases with its wear depth."""

    title: ClassVar[str] = "running in of roughness"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    needs_if: ClassVar[NeedsIf] = {
        ("acts_on", "wear_law"): (_LAW,),
        ("acts_on", "micropitting"): (_MODE,),
        ("acts_on", "both"): (_LAW, _MODE),
    }
    validity: ClassVar[str] = "mild wear that smooths; both flanks equally rough when new"
    references: ClassVar[tuple[str, ...]] = (
        "Queener, Smith and Mitchell 1965, Wear 8, 391-400 (a transient that decays exponentially with wear)",
        "Hu, Li and Tonder 1991, J. Tribology 113, 499-505 (roughness that runs in to an equilibrium)",
    )

    acts_on: str = declared(
        choice("wear_law", "micropitting", "both"),
        "Effects that use the run-in roughness: `wear_law.lubrication`, `micropitting`, or `both`.",
        default="wear_law",
    )
    strength: float = declared(
        between(number, 0.0, 0.95, "the share of the roughness removed: 0.2 to 0.6 is usual for ground flanks"),
        "Share of the roughness that running in finally removes.",
        default=0.5,
    )
    depth_um: float = declared(
        above(0.0, 100.0, "in um: about the roughness Ra itself, 0.3 to 3, is usual", "um"),
        "Wear depth at which 63 % of that share is removed.",
        default=1.0,
    )
