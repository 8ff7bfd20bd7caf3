"""Dotted keys of a scenario's table: what ``--set`` and a variation write, and what follows from it."""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from typing import Any

from pydantic import BaseModel

from ehamj.errors import InputError
from ehamj.isolator.presets import ACTUATOR_PRESETS, NAMED
from ehamj.plain.text import toml_of
from ehamj.plant.mounts import DEFAULT_MOUNTS
from ehamj.settings import PROVENANCE

OPENING = ('"', "'", "[", "{")
"""What strings, lists and tables of TOML begin with."""


def override(table: dict[str, Any], text: str) -> None:
    """Put ``key=value`` into a scenario's table: a dotted key, and a TOML value or else a string.

    Raises:
        InputError: if it has not that form, or the key leads nowhere.
    """
    key, equals, value = text.partition("=")
    said, parts = f"--set {text!r}", parts_of(key)
    if not equals or not all(parts):
        raise InputError(f"{said}: must be key=value, such as machine.mass=4500")
    found = written(value)
    if isinstance(found, str) and found == value.strip() and found.startswith(OPENING):
        raise InputError(
            f"{said}: {found!r} begins as a TOML value and is none: a quote or bracket is not closed, or a word within "
            f"stands without quotes; a string that begins so stands in quotes itself"
        )
    place(table, parts, found, said)


def parts_of(key: str) -> list[str]:
    """Parts of a dotted key as a user writes it; one in quotes may hold dots, as in ``vary."machine.mass"``."""
    if '"' in key or "'" in key:
        try:
            found, at = [], toml_of(f"{key} = 0")
            while isinstance(at, dict):
                ((part, at),) = at.items()
                found.append(part)
            return found
        except ValueError:  # the quotes are part of a name
            pass
    return [part.strip() for part in key.split(".")]


def other_kinds(overrides: Sequence[str], before: Mapping[str, Any], found: str) -> str:
    """The way out of what was ``found`` wrong where an override made a table one of another kind, and the keys of the
    kind that it was ``before`` stayed; empty where that is not so."""
    said = ""
    for key, _, value in (text.partition("=") for text in overrides):
        *parents, last = parts_of(key)
        where, kind = ".".join(parents), written(value)
        if last != "kind" or not re.search(rf"^{re.escape(where)}\.\S+ = .*unknown key", found, re.MULTILINE):
            continue
        former = reduce(lambda at, part: at.get(part, {}) if isinstance(at, Mapping) else {}, parents, before)
        if isinstance(former, Mapping) and former.get("kind") != kind:
            said += (
                f"\n{where} was of kind {former.get('kind')!r}, and its other keys stayed; to begin anew: "
                f"--set '{where}={{kind=\"{kind}\"}}'"
            )
    return said


def written(text: str) -> Any:
    """The value of what a user wrote: TOML, or else a string."""
    try:
        return toml_of(f"value = {text}")["value"] if "\n" not in text else text.strip()
    except ValueError:
        return text.strip()


def place(table: dict[str, Any], key: str | Sequence[str], value: Any, said: str) -> None:
    """Set the value of a dotted key, or of one in parts; ``said`` is what messages begin with.

    Tables and lists within ``table`` are replaced, not changed: others may hold them too.

    A table as a result holds it states its values' sources. Source and deviation of a value go where it, or a number
    of it, is replaced; so do values that came from the preset, oil or valve that is replaced, and an inertia that
    nobody gave with the mass or size that is.
    """
    *parents, last = (part.strip() for part in (key.split(".") if isinstance(key, str) else key))
    if parents[:1] == ["mount"]:
        table.setdefault("mount", [mount.model_dump(mode="json") for mount in DEFAULT_MOUNTS])
    at: Any = table
    owner, owned = table, last
    for depth, part in enumerate(parents):
        of: Any = _index(at, part, said) if isinstance(at, list) else part
        inner = at[of] if isinstance(at, list) else at.get(of, {})
        if not isinstance(inner, dict | list):
            raise InputError(f"{said}: {'.'.join(parents[: depth + 1])} is a value, not a table")
        if isinstance(at, dict):
            owner, owned = at, part
        at[of] = inner.copy()
        at = at[of]
    if isinstance(at, dict):
        owner, owned = at, last
    known = {key: owner[key].copy() for key in PROVENANCE if isinstance(owner.get(key), dict)}
    owner |= known
    if "sources" in known and owner is at:
        _follow(owner, known["sources"], (*parents, last), value)
    for told in known.values():
        told.pop(owned, None)
    at[_index(at, last, said) if isinstance(at, list) else last] = value


def _follow(at: dict[str, Any], sources: dict[str, Any], key: tuple[str, ...], value: Any) -> None:
    """Let go of what a table holds only because of the value that is replaced."""
    *parents, last = key
    if parents[-2:-1] == ["actuators"] and last in NAMED and value != at.get(last):
        own = at.get("deviations", {})  # fitted to measurements: no preset's
        for name in [name for name, source in sources.items() if source != "given" and name not in own]:
            at.pop(name, None)
            del sources[name]
        former = ACTUATOR_PRESETS.get(str(at.get("preset")))
        for name in [name for name in at if name not in (*NAMED, *sources, *PROVENANCE)]:  # without a source
            if last == "preset" and former is not None and at[name] == getattr(former, name, None):
                at.pop(name)
    if parents[-1:] == ["machine"] and last in ("mass", "size") and sources.get("inertia") == "assumed":
        at.pop("inertia", None)
        del sources["inertia"]


def _index(place: list[Any], part: str, said: str) -> int:
    """Which entry of a list a part of a key means: its number, or its name where entries have one."""
    names = [entry.get("name") for entry in place if isinstance(entry, Mapping)]
    if part in names:
        return names.index(part)
    if not part.isdigit() or int(part) >= len(place):
        named = f", or one of {', '.join(map(repr, names))}" if any(names) else ""
        raise InputError(f"{said}: {part!r} must be an index from 0 to {len(place) - 1}{named}")
    return int(part)


def merge(table: dict[str, Any], other: Mapping[str, Any], said: str) -> None:
    """Place every value of a nested table into another one; lists replace what is there."""
    for key, value in sorted(leaves(other), key=lambda leaf: not set(PROVENANCE).isdisjoint(leaf[0])):
        place(table, key, value, said)


def leaves(table: Mapping[str, Any], before: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every value that is no table, with the keys that lead to it."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from leaves(value, (*before, str(key)))
        else:
            yield (*before, str(key)), value


def entries(table: Mapping[str, Any], before: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """As `leaves`, but a table that states its ``kind`` is one value, whole."""
    for key, value in table.items():
        if isinstance(value, Mapping) and "kind" not in value:
            yield from entries(value, (*before, str(key)))
        else:
            yield (*before, str(key)), value


def plain(value: Any) -> Any:
    """The value as TOML would give it: tables for settings, lists for tuples."""
    if isinstance(value, BaseModel):
        return plain(value.model_dump(mode="python", exclude_none=True))
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    return [plain(entry) for entry in value] if isinstance(value, tuple | list) else value


def differences(one: Mapping[str, Any], other: Mapping[str, Any], before: str = "") -> dict[str, tuple[Any, Any]]:
    """Values of two nested tables that differ, by dotted key; where they come from does not count."""
    found: dict[str, tuple[Any, Any]] = {}
    for key in dict.fromkeys((*one, *other)):
        ours, theirs = one.get(key), other.get(key)
        if key in PROVENANCE or ours == theirs:
            continue
        if isinstance(ours, Mapping) and isinstance(theirs, Mapping):
            found |= differences(ours, theirs, f"{before}{key}.")
        else:
            found[f"{before}{key}"] = (ours, theirs)
    return found
