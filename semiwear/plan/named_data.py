"""Named data that a scene uses, as rows of its plan: what they are, where they come from, what the scene changes."""

from __future__ import annotations

from collections.abc import Iterator

from semiwear.plan.choices import Choice
from semiwear.references.citations import titled
from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_set
from semiwear.scene import BodyData, Scene
from semiwear.scene.rules import BODIES

__all__ = ["data_choices"]

_GOLD = "gold2001"  # whence the pressure-viscosity coefficients of oils


def data_choices(scene: Scene) -> Iterator[Choice]:
    """A choice for every set of data that the scene names."""
    for body in BODIES:
        material = getattr(scene.material, body)
        if material.data is not None:
            yield _choice(f"material.{body}.data", MATERIALS, material.data, _own(material, material.data))
    wear = scene.wear
    if wear is not None and wear.data is not None:
        named = wear.data.given if isinstance(wear.data, BodyData) else dict.fromkeys(wear.worn_bodies, wear.data)
        for name in dict.fromkeys(named.values()):
            numbers = {
                wear.coefficient(body) for body, its in named.items() if its == name and body in wear.worn_bodies
            }
            published = named_set(WEAR, name)["coefficient_mm2_per_N"]
            yield _choice("wear.data", WEAR, name, sorted(f"{k:g} mm2/N" for k in numbers if k != published))
    for effect in ("friction", "lubrication"):
        table = getattr(scene.effects, effect)
        if table is not None and table.data is not None:
            yield _choice(f"effects.{effect}.data", OILS, table.data, [], (_GOLD,))


def _own(material: object, name: str) -> list[str]:
    """Numbers of a scene's own in a material's place."""
    published = named_set(MATERIALS, name)
    fields = ("youngs_modulus_MPa", "poissons_ratio")
    return [f"{key} = {value:g}" for key in fields if (value := getattr(material, key)) != published[key]]


def _choice(slot: str, kind: str, name: str, own: list[str], further: tuple[str, ...] = ()) -> Choice:
    found = named_set(kind, name)
    why = str(found.get("conditions", found.get("title", name)))
    if kind == WEAR:
        why = f"{found['of']} against {found['against']}; {'known roughly; ' if found['rough'] else ''}{why}"
    if own:
        why += f"; the scene has numbers of its own: {', '.join(own)}"
    references = (titled(found["source"], found["place"]), *(titled(key) for key in further))
    return Choice(slot, name, True, why, references)
