"""TOML text to nested dicts, and back for the content of a scene."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping

from semiwear.errors import Problem, SceneError
from semiwear.scene.values import shown
from semiwear.untyped import Table, Value

_SHORT_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}


def read_toml(text: str, name: str) -> Table:
    """The tables of a TOML text.

    Raises
    ------
    SceneError
        If the text is not TOML; the message gives the line.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        problem = _syntax_problem(text, str(error))
    except ValueError:  # an integer of too many digits to convert
        problem = Problem("file", "a number of thousands of digits", "TOML with plain values", "shorten it")
    except RecursionError:
        problem = Problem("file", "lists nested without end", "TOML with plain values", "take the lists apart")
    raise SceneError([problem], name)


def _syntax_problem(text: str, message: str) -> Problem:
    lines = text.splitlines() or [""]
    match = re.search(r"at line (\d+)", message)
    number = min(int(match.group(1)), len(lines)) if match else len(lines)
    line = lines[number - 1].strip()
    return Problem(f"line {number}", shown(line), "TOML syntax", f"{message}{_syntax_advice(line, message)}")


def _syntax_advice(line: str, message: str) -> str:
    """Probable correction of a line that is not TOML."""
    value = line.partition("=")[2].partition("#")[0].strip()
    if "Unclosed array" in message:
        return "; close the list with ] on this line or on one before"
    if line.startswith("["):
        return "; each table has one header, [name], in a line of its own"
    if "overwrite" in message:
        return "; the field occurs twice: remove one"
    if re.match(r"(\{.*= *)?[-+]?\d+,\d", value):
        return "; write a decimal point, not a comma"
    if re.match(r"[-+.\d]+(e[-+]?\d+)? *[a-zA-Z%°]", value):
        return "; leave the unit out, it is in the field's name"
    if value.count('"') % 2:
        return '; close the text with "'
    if "=" not in line:
        return "; write name = value, or # before a remark"
    if value.casefold() in ("", "none", "null", "nil"):
        return "; leave the line out where there is no value"
    return "; write text in quotes, true and false in small letters" if value[:1].isalpha() else ""


def flat(table: Mapping[str, Value], path: str = "", inline: Collection[str] = ()) -> Iterator[tuple[str, Value]]:
    """Fields of nested tables under their dotted keys.

    An empty table, which may be an effect, is included itself, as are those whose keys are `inline`.
    """
    for name, value in table.items():
        key = f"{path}{name}"
        if isinstance(value, Mapping) and value and key not in inline:
            yield from flat(value, f"{key}.", inline)
        else:
            yield key, value


def write_toml(data: Mapping[str, Value], *, inline: Collection[str] = ()) -> str:
    """TOML text of nested mappings of text, numbers and flat lists; numbers are read back exactly.

    Parameters
    ----------
    data : mapping
        The tables; an empty one is written as well, since it may be an effect.
    inline : collection of str
        Dotted keys of the mappings that are written in braces on one line.
    """
    return "\n".join(_table_lines(data, "", inline)).lstrip("\n") + "\n"


def _table_lines(table: Mapping[str, Value], path: str, inline: Collection[str]) -> list[str]:
    prefix = f"{path}." if path else ""
    inner = {key for key, value in table.items() if isinstance(value, Mapping) and f"{prefix}{key}" not in inline}
    lines = [f"{key} = {_value(value)}" for key, value in table.items() if key not in inner]
    if path and (lines or not inner):
        lines = ["", f"[{path}]", *lines]
    for key in table:
        if key in inner:
            lines += _table_lines(table[key], f"{prefix}{key}", inline)
    return lines


def _value(value: Value) -> str:
    if isinstance(value, str):
        return '"' + "".join(_escaped(character) for character in value) + '"'
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return repr(value)


def _escaped(character: str) -> str:
    if character in _SHORT_ESCAPES:
        return _SHORT_ESCAPES[character]
    code = ord(character)
    return f"\\u{code:04X}" if code < 0x20 or code == 0x7F else character
