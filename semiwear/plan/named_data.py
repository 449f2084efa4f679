"""Named data sets of a scene as rows of its plan, with their sources and conditions."""

from __future__ import annotations

from collections.abc import Iterator

from semiwear.plan.choices import Choice
from semiwear.references.citations import titled
from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_set
from semiwear.scene import BodyData, Scene
from semiwear.scene.rules import BODIES

_GOLD = "gold2001"  # source of the pressure-viscosity coefficients of oils


def data_choices(scene: Scene) -> Iterator[Choice]:
    """A choice for every data set named by the scene."""
    for body in BODIES:
        if (name := getattr(scene.material, body).data) is not None:
            yield _choice(f"material.{body}.data", MATERIALS, name)
    wear = scene.wear
    if wear is not None and wear.data is not None:
        names = wear.data.given.values() if isinstance(wear.data, BodyData) else (wear.data,)
        for name in dict.fromkeys(names):
            yield _choice("wear.data", WEAR, name)
    for effect in ("friction", "lubrication"):
        table = getattr(scene.effects, effect)
        if table is not None and table.data is not None:
            yield _choice(f"effects.{effect}.data", OILS, table.data, (_GOLD,))


def _choice(slot: str, kind: str, name: str, further: tuple[str, ...] = ()) -> Choice:
    found = named_set(kind, name)
    why = str(found.get("conditions", found.get("title", name)))
    if kind == WEAR:
        why = f"{found['of']} against {found['against']}; {'known roughly; ' if found['rough'] else ''}{why}"
    references = (titled(found["source"], found["place"]), *(titled(key) for key in further))
    return Choice(slot, name, True, why, references)
