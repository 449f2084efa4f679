"""Citations as BibTeX: entries of `bibliography.bib` for the sources of a result."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from importlib import resources

_ENTRY = re.compile(r"^@\w+\{([^,]+),", re.MULTILINE)
_STANDARD = re.compile(r"ISO(?:/TR)? (\d+(?:-\d+)?):(\d{4})")
# the last capitalised words before a year are its authors: "Keer, Lee and Mura 1983"
_AUTHORS = re.compile(r"((?:[A-Z][\w'’-]+(?:, | and )?(?:et al\. )?)+) (\d{4})\b")
_OWN = "semiwear"


@cache
def bibliography() -> dict[str, str]:
    """BibTeX entries by key."""
    text = resources.files(__package__).joinpath("bibliography.bib").read_text(encoding="utf-8")
    return {match.group(1): line for line in text.splitlines() if (match := _ENTRY.match(line))}


def keys_of(reference: str) -> list[str]:
    """Keys of all works cited in a text, such as `johnson1985` or `iso21771-2007`."""
    named = re.match(r"([a-z][\w-]*): ", reference)
    if named and named.group(1) in bibliography():
        return [named.group(1)]
    keys = [f"iso{number}-{year}" for number, year in _STANDARD.findall(reference)]
    for authors, year in _AUTHORS.findall(_STANDARD.sub("", reference)):
        first = re.split(r", | and | et ", authors)[0].split()[-1]
        keys.append(f"{first.lower()}{year}")
    return list(dict.fromkeys(keys))


def titled(key: str, place: str = "") -> str:
    """Citation of a work in words; `keys_of` finds its key again."""
    entry = bibliography()[key]
    title = re.search(r"\b(?:title|journal) = \{(.*?)\}[,}]", entry)
    year = re.search(r"\byear = \{(\d+)\}", entry)
    words = re.sub(r"[{}]", "", title.group(1)) if title else ""
    work = f"{words} ({year.group(1)})" if words and year else words or (year.group(1) if year else "")
    return f"{key}: {', '.join(part for part in (work, place) if part)}"


def bibtex(references: Iterable[str], version: str) -> str:
    """BibTeX entries of the software and of all works cited in texts, each work once.

    A work that is not in the bibliography becomes an entry with the text as its title.

    Parameters
    ----------
    references : iterable of str
        Citations in words.
    version : str
        Version of the software.
    """
    entries = {
        _OWN: f"@software{{{_OWN}, author = {{{{The semiwear developers}}}}, title = {{semiwear: gear tooth wear}}, "
        f"version = {{{version}}}}}"
    }
    known = bibliography()
    for reference in references:
        keys = keys_of(reference)
        found = [key for key in keys if key in known]
        entries |= {key: known[key] for key in found}
        if not found:
            key = keys[0] if keys else re.sub(r"\W+", "", reference.lower())[:24]
            entries[key] = f"@misc{{{key}, title = {{{_escaped(reference)}}}}}"
    return "\n".join(entries.values())


def _escaped(text: str) -> str:
    return re.sub(r"([%&#_$])", r"\\\1", text.replace("{", "(").replace("}", ")"))
