"""What the names beside an array of a MATLAB file say of it: its unit, and what it is called.

Known are plain names in any case (``units``, ``z_unit``, ``label``), and what these programs write: B&K PULSE
(``Channel_1_Header.Unit`` and ``SignalName``), Simcenter Testlab (``y_values.quantity``), Simulink (``signals.label``).
"""

import re
from typing import Any

from ehamj.records.choices import Choices
from ehamj.records.units import is_silent, kind_of, unit

Scope = dict[str, Any]
"""A struct, or the file's variables: what stands beside an array."""

HEADS = frozenset(
    (
        "fileheader",
        "header",
        "head",
        "info",
        "meta",
        "metadata",
        "xvalues",
        "properties",
        "settings",
        "parameters",
        "params",
    )
)
"""Structs that say something of the arrays beside them."""

GENERIC = frozenset(("values", "data", "yvalues", "signal", "signals", "samples", "y", "value"))
"""Names that say nothing; the struct around is the name."""

LABELS = ("label", "signalname", "channelname", "title", "name")
LISTS = ("labels", "channels", "channelnames", "names", "columns", "variables", "signalnames")


def plain(key: str) -> str:
    """A name in small letters, without what parts its words."""
    return re.sub(r"[^a-z0-9]", "", key.lower())


def unit_beside(scope: Scope, key: str) -> str:
    """The text that states the unit of ``key`` itself, empty where there is none."""
    names = {plain(f"{key}{word}") for word in ("unit", "units")} | {
        plain(f"{word}{key}") for word in ("unit", "units")
    }
    found = [v for k, v in scope.items() if plain(k) in names and isinstance(v, str)]
    for k, v in scope.items():
        if plain(k) in ("unit", "units") and isinstance(v, dict):
            found += [text for name, text in v.items() if plain(name) == plain(key) and isinstance(text, str)]
    return next((text for text in found if not is_silent(text)), "")


def _header(scope: Scope, key: str) -> Scope:
    """The struct of B&K's that describes ``Channel_1_Data``: ``Channel_1_Header``."""
    wanted = re.sub("data$", "header", plain(key))
    found = (v for k, v in scope.items() if plain(k) == wanted and plain(k) != plain(key) and isinstance(v, dict))
    return next(found, {})


def unit_of(name: str, key: str, scopes: tuple[Scope, ...], number: int, columns: int, choices: Choices) -> str | None:
    """The unit that is stored beside an array; None where there is none, or where it would be a guess."""
    quantity = scopes[0].get("quantity")
    if isinstance(quantity, dict) and plain(key) == "values":
        return _testlab(name, quantity, choices)
    for scope in scopes:
        header = _header(scope, key) if scope is scopes[0] else {}
        texts: list[Any] = [unit_beside(scope, key) if scope is scopes[0] else ""]
        for place in (header, scope, *(v for k, v in scope.items() if plain(k) in HEADS and isinstance(v, dict))):
            texts += [v for k, v in place.items() if plain(k) in ("unit", "units")]
        for text in texts:
            chosen = text[number] if isinstance(text, list) and len(text) == columns else text
            if isinstance(chosen, str) and not is_silent(chosen) and kind_of(chosen) != "time":
                return chosen.strip()
    return None


def _testlab(name: str, quantity: Scope, choices: Choices) -> str | None:
    """Testlab's unit: whether numbers are in it or in SI is told differently by different versions."""
    label = quantity.get("label")
    if not isinstance(label, str) or is_silent(label) or choices.unit is not None:
        return None
    try:
        if unit(label).size == 1.0:
            return label
    except ValueError:
        return label
    raise ValueError(
        f"ground.file: {name} states the unit {label!r}, but not whether its numbers are in it or in SI; say "
        "which with ground.unit"
    )


def labels_of(name: str, key: str, scopes: tuple[Scope, ...], number: int, columns: int) -> list[str]:
    """Other names of an array's column: labels beside it, and the struct around where its own name says nothing."""
    scope = scopes[0]
    found: list[str] = []
    places = [_header(scope, key), *([scope] if plain(key) in GENERIC else [])]
    found += [v for place in places for k, v in place.items() if plain(k) in LABELS and isinstance(v, str)]
    if columns > 1:
        lists = [v for k, v in scope.items() if plain(k) in LISTS and isinstance(v, list) and len(v) == columns]
        found += [str(one[number]) for one in lists if isinstance(one[number], str)]
    elif plain(key) in GENERIC:
        around = [part for part in name.split(".") if plain(re.sub(r"\(\d+\)$", "", part)) not in GENERIC]
        found.append(around[-1] if around else name.split(".")[0])
    return [text.strip() for text in found if text.strip()]
