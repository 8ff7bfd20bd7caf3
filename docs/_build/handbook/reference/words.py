"""What a JSON schema says of one key, in words: what is allowed, and by default."""

import re
from collections.abc import Iterator
from typing import Any, Final

from ehamj.bounds import BOUNDS, unit_of

Node = dict[str, Any]
"""A node of a JSON schema."""

TYPES: Final = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "null": "nothing",
    "object": "table",
}
LIMITS: Final = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def referred(node: Any) -> Iterator[str]:
    """Names of the definitions that a node leads to, in order, each once."""
    found: dict[str, None] = {}

    def walk(at: Any) -> None:
        if isinstance(at, dict):
            if "$ref" in at:
                found[at["$ref"].rpartition("/")[2]] = None
            for name, below in at.items():
                if name not in ("default", "discriminator"):
                    walk(below)
        elif isinstance(at, list):
            for below in at:
                walk(below)

    walk(node)
    return iter(found)


def unit(node: Node) -> str | None:
    """Unit of a key [-: none has]."""
    return node.get("unit") or unit_of(node.get("description"))


def allowed(node: Node) -> str:
    """What a key may be."""
    parts = node.get("anyOf") or node.get("oneOf")
    if parts is not None:
        said = [allowed(part) for part in parts if part.get("type") != "null"]
        return " or ".join(dict.fromkeys(said))
    if "$ref" in node:
        return "a table"
    if "const" in node:
        return f"`{value(node['const'])}`"
    if "enum" in node:
        return ", ".join(f"`{value(one)}`" for one in node["enum"])
    if node.get("type") == "array":
        return _list(node)
    if node.get("type") == "object":
        below = node.get("additionalProperties")
        return f"a table of names, each {allowed(below)}" if isinstance(below, dict) and below else "a table"
    limits = " and ".join(f"{sign} {number(node[name])}" for name, sign in LIMITS.items() if name in node)
    words = TYPES.get(node.get("type", ""), "any value")
    return f"{words} {limits}".rstrip()


def _list(node: Node) -> str:
    if "prefixItems" in node:
        kinds = [allowed(one) for one in node["prefixItems"]]
        same = len(set(kinds)) == 1
        return f"{len(kinds)} × {kinds[0]}" if same else f"list of {', '.join(kinds)}"
    least, most = node.get("minItems", 0), node.get("maxItems")
    count = f"{least} to {most} of: " if most is not None else f"at least {least} of: " if least else "any number of: "
    return f"list, {count}{allowed(node.get('items', {}))}"


def magnitude(node: Node) -> str | None:
    """The magnitudes beyond which a value is refused as a slip of unit or decimal point."""
    known = unit(node)
    if known not in BOUNDS or known == "-":
        return None
    least, largest = BOUNDS[known]
    least = least if "exclusiveMinimum" in str(node) else 0.0
    return f"at most {number(largest)}" if least == 0.0 else f"{number(least)} to {number(largest)}"


def number(given: float) -> str:
    """A number as a person writes it, every digit that it has."""
    short = f"{given:g}"
    text = short if float(short) == given else repr(given)
    return re.sub(r"e\+?(-?)0*(\d)", r"e\1\2", text)


def value(given: Any) -> str:
    """A value as TOML has it, in one line."""
    if isinstance(given, bool):
        return str(given).lower()
    if isinstance(given, float):
        return number(given)
    if isinstance(given, str):
        return f'"{given}"'
    if isinstance(given, list | tuple):
        return f"[{', '.join(map(value, given))}]"
    if isinstance(given, dict):
        inside = ", ".join(f"{name} = {value(one)}" for name, one in given.items() if one is not None)
        return f"{{ {inside} }}" if inside else "{}"
    return str(given)
