"""A REXS file as components and relations: XML, JSON, or either zipped.

Sources: REXS 1.0 to 2.0 (FVA, rexs.info), its XML and JSON schemas and data model as published with the REXS API
(fva-net/rexs-api-java, Apache 2.0).
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from semiwear.errors import SceneError
from semiwear.untyped import Value

_VERSIONS = ("1.", "2.")
_ALLOWED = "a REXS file: *.rexs (XML), *.rexsj (JSON) or *.rexsz (zipped)"
_MOST_BYTES = 64 << 20  # of a model: gear units with results have some hundred kilobytes
_VALUES = ("floating_point", "integer", "string", "enum", "boolean", "file_reference", "reference_component")


@dataclass(frozen=True)
class Attribute:
    """A single value with its unit.

    Attributes
    ----------
    value : object
        A string of XML, a JSON value, or None for arrays and matrices.
    unit : str
    """

    value: Value
    unit: str


@dataclass(frozen=True)
class Component:
    """A component of a gear unit.

    Attributes
    ----------
    id, type, name : str
    attributes : mapping from name to Attribute
    """

    id: str
    type: str
    name: str
    attributes: Mapping[str, Attribute]

    def __str__(self) -> str:
        return f"{self.type} {self.id}" + (f" ({self.name})" if self.name else "")


@dataclass(frozen=True)
class Relation:
    """A relation between components.

    Attributes
    ----------
    type : str
    ends : mapping from role to the id of a component
    """

    type: str
    ends: Mapping[str, str]


@dataclass(frozen=True)
class RexsModel:
    """Components and relations of a file.

    Attributes
    ----------
    version : str
    components : mapping from id to Component
    relations : tuple of Relation
    load_cases : tuple of mappings from id to Component
        Components with their values under a load.
    """

    version: str
    components: Mapping[str, Component]
    relations: tuple[Relation, ...]
    load_cases: tuple[Mapping[str, Component], ...]

    def related(self, kind: str, **ends: str) -> Iterator[Mapping[str, str]]:
        """Ends of the relations of a kind with the given components in the given roles."""
        for relation in self.relations:
            if relation.type == kind and all(relation.ends.get(role) == number for role, number in ends.items()):
                yield relation.ends


def read_model(path: str | os.PathLike[str]) -> RexsModel:
    """The model of a REXS file.

    Raises
    ------
    SceneError
        For a file that is missing, damaged, too large, or of another format or version.
    """
    file = Path(path)
    if not file.is_file():
        raise SceneError.of("path", str(file), _ALLOWED, "no such file")
    try:
        data = _unzipped(file) if zipfile.is_zipfile(file) else _bounded(file.read_bytes(), file)
        begin = data.lstrip(b"\xef\xbb\xbf \t\r\n")[:1]
        model = _of_json(data) if begin == b"{" else _of_xml(data)
    except (ElementTree.ParseError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        if isinstance(error, SceneError):
            raise
        found = f"{file}: {type(error).__name__}: {error}"
        raise SceneError.of("path", found, _ALLOWED, "it is damaged or no REXS file: export it again") from error
    if not model.version.startswith(_VERSIONS):
        raise SceneError.of(
            "path", f"{file}: REXS {model.version or 'without a version'}", "REXS 1 or 2", "export it as REXS 2"
        )
    missing = {number for relation in model.relations for number in relation.ends.values()} - model.components.keys()
    if missing:
        found = f"{file}: relations to components {', '.join(sorted(missing))}, which it does not contain"
        raise SceneError.of("path", found, _ALLOWED, "it is damaged: export it again")
    return model


def _bounded(data: bytes, file: Path) -> bytes:
    if len(data) > _MOST_BYTES:
        found = f"{file}: {len(data):.3g} bytes"
        raise SceneError.of("path", found, f"at most {_MOST_BYTES}", "export the gears alone")
    return data


def _unzipped(file: Path) -> bytes:
    with zipfile.ZipFile(file) as archive:
        names = [name for name in archive.namelist() if name.casefold().endswith((".rexs", ".rexsj"))]
        if len(names) != 1:
            raise ValueError(f"{len(names)} REXS models in the archive, not one")
        if archive.getinfo(names[0]).file_size > _MOST_BYTES:
            raise SceneError.of(
                "path", f"{file}: too large", f"at most {_MOST_BYTES} bytes", "export the gears alone"
            )
        return archive.read(names[0])


def _of_xml(data: bytes) -> RexsModel:
    root = ElementTree.fromstring(data)
    if root.tag != "model":
        raise ValueError(f"its root is <{root.tag}>, not <model>")
    relations = [
        Relation(element.attrib["type"], {end.attrib["role"]: end.attrib["id"] for end in element.iter("ref")})
        for element in root.findall("relations/relation")
    ]
    cases = [_xml_components(case.findall("component")) for case in root.findall("load_spectrum/load_case")]
    components = _xml_components(root.findall("components/component"))
    return RexsModel(root.attrib.get("version", ""), components, tuple(relations), tuple(cases))


def _xml_components(elements: list[ElementTree.Element]) -> dict[str, Component]:
    found = {}
    for element in elements:
        attributes = {
            each.attrib["id"]: Attribute((each.text or "").strip() if not len(each) else None, each.get("unit", ""))
            for each in element.findall("attribute")
        }
        number = element.attrib["id"]
        found[number] = Component(number, element.get("type", ""), element.get("name", ""), attributes)
    return found


def _of_json(data: bytes) -> RexsModel:
    model = json.loads(data.decode("utf-8-sig"))["model"]
    relations = [
        Relation(entry["type"], {end["role"]: str(end["id"]) for end in entry.get("refs", ())})
        for entry in model.get("relations", ())
    ]
    spectrum = model.get("load_spectrum") or {}
    cases = [_json_components(case.get("components", ())) for case in spectrum.get("load_cases", ())]
    components = _json_components(model["components"])
    return RexsModel(str(model.get("version", "")), components, tuple(relations), tuple(cases))


def _json_components(entries: list[Value]) -> dict[str, Component]:
    found = {}
    for entry in entries:
        attributes = {}
        for each in entry.get("attributes", ()):
            value = next((each[kind] for kind in _VALUES if kind in each), None)
            attributes[each["id"]] = Attribute(value, each.get("unit", ""))
        number = str(entry["id"])
        found[number] = Component(number, entry.get("type", ""), entry.get("name", ""), attributes)
    return found
