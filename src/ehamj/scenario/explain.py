"""What is wrong with a scenario, in words: key, value, and what is allowed."""

import re
from collections.abc import Mapping, Sequence, Sized
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from ehamj.bounds import unit_of
from ehamj.errors import InputError, did_you_mean
from ehamj.scenario.places import by_kind, choices, inside, keys_of, only
from ehamj.settings import PROVENANCE, Settings

T = TypeVar("T", bound=Settings)

LONG = 50
"""Entries of a list or a table beyond which it is not shown."""
QUOTED = re.compile(r"'([^']*)'")
"""What is allowed, of a list in words."""
LONGEST_KEY = 80
"""Letters of a key that are shown: longer ones are none of ours."""
MOST_SAID = 20
"""Findings of which one speaks at a time."""


def checked(kind: type[T], table: Mapping[str, Any]) -> T:
    """Settings of a kind from a table.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        raise InputError(explain(error, kind)) from None


def explain(error: ValidationError, kind: type[Settings]) -> str:
    """Pydantic's findings as one plain message, a line per key: key = value: what is allowed."""
    findings = error.errors(include_url=False)
    inside = {found["loc"][:depth] for found in findings for depth in range(len(found["loc"]))}
    lines: dict[str, list[str]] = {}
    for found in findings[:MOST_SAID]:
        if found["type"] == "too_short" and found["loc"] in inside:
            continue  # only because pydantic left out the entry that another finding names
        what, allowed = _finding(found, kind)
        lines.setdefault(what, []).append(allowed)
    said = [f"{what}: {', or '.join(dict.fromkeys(allowed))}".removeprefix(": ") for what, allowed in lines.items()]
    left = len(findings) - MOST_SAID
    return "\n".join(said + ([f"and {left} more"] if left > 0 else []))


def _finding(found: Any, settings: type[Settings]) -> tuple[str, str]:
    """One finding as ``key = value`` and what is allowed there."""
    location, value, kind, context = found["loc"], found.get("input"), found["type"], found.get("ctx", {})
    key = _key(location, settings)
    if isinstance(value, str) and Path(value).is_absolute() and not Path(value).suffix:
        value = Path(value).name  # a name that is none, and was taken for that of a file
    message = found["msg"].removeprefix("Value error, ").replace(" after validation", "")
    message = re.sub(r"^(Input|String|Tuple|Dictionary) should (be|have)\b", r"must \2", message)
    if kind == "extra_forbidden":
        message = _no_such_key(str(location[-1]), tuple(keys_of(only(_walk(location[:-1], settings)[1]))))
    elif kind == "union_tag_invalid":
        tags = context["expected_tags"]
        near = did_you_mean(str(context["tag"]), QUOTED.findall(tags))
        key, value, message = f"{key}.kind", context["tag"], f"{near}must be one of {tags}"
    elif kind == "literal_error" and isinstance(value, str):
        message = f"{did_you_mean(value, QUOTED.findall(context['expected']))}{message}"
    elif kind == "union_tag_not_found":
        kinds = by_kind(_walk(location, settings)[1])
        return f"{key}.kind", f"is missing; must be one of {', '.join(map(repr, sorted(kinds)))}"
    elif kind in ("model_type", "model_attributes_type", "dict_type"):
        kinds = by_kind(_walk(location, settings)[1])
        message = f"must be a table{f', such as {{ kind = {value!r} }}' if str(value) in kinds else ''}"
    elif kind == "float_type":
        message = f"must be a valid number{_in_its_unit(location, settings)}"
    elif kind == "tuple_type":
        message = "must be a list in brackets, its entries between commas"
        if isinstance(value, Mapping) and all(str(number).isdigit() for number in value):
            message += "; an entry of it is set by its number only where the scenario states the list"
    elif kind == "missing" and isinstance(location[-1], int):
        key, message = _key(location[:-1], settings), f"entry {location[-1] + 1} is missing"
    elif kind == "missing":
        return key, "is missing"
    elif kind == "value_error" and isinstance(value, Mapping):
        own = re.match(r"([a-z_]+)(?:\.\w+)*(?: = [^:]*)?: ", message)
        if key and own and own[1] in value:  # of a key in the table
            return f"{key}.{own[0].removesuffix(': ')}", message.removeprefix(own[0])
        return key, message
    if isinstance(value, Sized) and len(value) > LONG and not isinstance(value, str):
        return key, message
    shown = repr(list(value) if isinstance(value, tuple) else value)
    return f"{key} = {shown if len(shown) <= 200 else shown[:200] + '…'}", message


def _in_its_unit(location: tuple[int | str, ...], settings: type[Settings]) -> str:
    """In which unit the number of a key is stated, where it has one."""
    table, name = only(_walk(location[:-1], settings)[1]), str(location[-1])
    field = table.model_fields.get(name) if isinstance(table, type) and issubclass(table, Settings) else None
    unit = None if field is None else unit_of(field.description)
    return f", in {unit}" if unit not in (None, "-", "unit") else ""


def _no_such_key(key: str, allowed: Sequence[str]) -> str:
    """The keys that stand where an unknown one was found, nearest first."""
    told = sorted(allowed, key=lambda one: one in PROVENANCE)  # which none writes by hand comes last
    return f"unknown key; {did_you_mean(key, allowed)}allowed: {', '.join(told)}"


def _key(location: tuple[int | str, ...], settings: type[Settings]) -> str:
    return ".".join(_walk(location, settings)[0])


def _short(key: str) -> str:
    return key if len(key) <= LONGEST_KEY else f"{key[:LONGEST_KEY]}…"


def _walk(location: tuple[int | str, ...], settings: type[Settings]) -> tuple[list[str], Any]:
    """Where a location leads: the keys as the user wrote them (without the tags of unions), and the type there."""
    keys: list[str] = []
    kind: Any = settings
    for part in location:
        if by_kind(kind):
            kind = by_kind(kind)[str(part)]
        elif len(choices(kind)) > 1 and only(kind) is None:
            kind = None
        else:
            keys.append(_short(str(part)))
            kind = inside(only(kind), part)
    return keys, kind
