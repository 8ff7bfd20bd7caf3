"""The tables of a file of settings as pages: every key once, with an anchor of its own."""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from handbook.reference.words import Node, allowed, magnitude, referred, unit, value

SHARED_BY = 3
"""Kinds that have a key in common before it is described once for all of them."""


class Place(NamedTuple):
    """Where a table stands in a file: its dotted path, and of a table with kinds which of them."""

    path: str
    kind: str | None = None

    @property
    def anchor(self) -> str:
        """Of the table, and what those of its keys begin with."""
        return f"{self.path}.{self.kind}" if self.kind else self.path

    @property
    def heading(self) -> str:
        """As it is written in a file."""
        return f'`[{self.path}]`, `kind = "{self.kind}"`' if self.kind else f"`[{self.path}]`"


class Tables:
    """All tables of a JSON schema, each described where it is met first."""

    def __init__(self, schema: Node) -> None:
        self.schema = schema
        self.definitions: dict[str, Node] = schema.get("$defs", {})
        self.places: dict[str, list[Place]] = {}
        self.home: dict[str, str] = {}

    def below(self, key: str, node: Node) -> Iterator[tuple[str, Place]]:
        """The tables that a key holds, and those below them, with their places; each the first time that it is met."""
        names = list(referred(node))
        path = self._path(key, node, names)
        for name in names:
            kind = self.definitions[name]["properties"].get("kind", {}).get("const")
            place = Place(path, kind)
            known = name in self.places
            places = self.places.setdefault(name, [])
            if place not in places:
                places.append(place)
            if not known:
                yield name, place
        for name in names:
            if self.places[name][0].path == path:
                for below, one in self.definitions[name]["properties"].items():
                    yield from self.below(f"{path}.{below}", one)

    def _path(self, key: str, node: Node, names: list[str]) -> str:
        many = node.get("type") == "array" or any(one.get("type") == "array" for one in node.get("anyOf", ()))
        if node.get("additionalProperties"):
            return f"{key}.NAME"
        if many and names:
            named = all("name" in self.definitions[name]["properties"] for name in names)
            return f"{key}.NAME" if named else f"{key}.N"
        return key

    def page(self, title: str, intro: str, file: str, keys: list[str]) -> str:
        """Markdown of a page on some top-level keys that hold tables."""
        sections: list[tuple[str, Place]] = []
        for key in keys:
            sections += self.below(key, self.schema["properties"][key])
        self.home.update({name: file for name, _ in sections})
        shared = self._shared([name for name, place in sections if place.kind])
        parts = [f"# {title}\n\n{intro}\n"]
        if shared:
            parts.append(self._shared_section(keys[0], shared))
        parts += [self._section(name, place, shared, keys[0]) for name, place in sections]
        return "\n".join(parts)

    def _shared(self, names: list[str]) -> dict[str, tuple[Node, list[str]]]:
        """Keys that several kinds have alike, with the kinds."""
        found: dict[str, list[tuple[Node, str]]] = {}
        for name in names:
            for key, node in self.definitions[name]["properties"].items():
                if key not in ("kind", "name"):
                    found.setdefault(key, []).append((node, self.places[name][0].kind or ""))
        alike = {key: [kind for node, kind in have if node == have[0][0]] for key, have in found.items()}
        return {key: (found[key][0][0], kinds) for key, kinds in alike.items() if len(kinds) >= SHARED_BY}

    def _shared_section(self, key: str, shared: dict[str, tuple[Node, list[str]]]) -> str:
        parts = ["## Keys that several kinds have { #shared }\n"]
        for name, (node, kinds) in shared.items():
            told = f"Kinds: {', '.join(f'`{kind}`' for kind in kinds)}."
            parts.append(self.key(name, node, f"{key}.{name}", False) + f"\n{told}\n")
        return "\n".join(parts)

    def _section(self, name: str, place: Place, shared: dict[str, Any], key: str) -> str:
        definition = self.definitions[name]
        said = (definition.get("description") or "").strip()
        parts = [f"## {place.heading} {{ #{place.anchor} }}\n", f"{said}\n"]
        others = [one.heading for one in self.places[name][1:]]
        if others:
            parts.append(f"The same keys: {', '.join(others)}.\n")
        elsewhere = [one for one, (_, kinds) in shared.items() if place.kind in kinds]
        properties = definition.get("properties", {})
        here = {
            one: node for one, node in properties.items() if one not in elsewhere and one not in ("kind", "sources")
        }
        required = definition.get("required", ())
        if len(here) > 3:
            parts.append(summary_table({f"{place.anchor}.{one}": (one, node) for one, node in here.items()}))
        if elsewhere:
            links = ", ".join(f"[`{one}`](#{key}.{one})" for one in elsewhere)
            parts.append(f"As other kinds have them: {links}.\n")
        parts += [self.key(one, node, f"{place.anchor}.{one}", one in required) for one, node in here.items()]
        return "\n".join(parts)

    def key(self, name: str, node: Node, anchor: str, required: bool) -> str:
        """One key: a heading that search finds, what it means, and its facts."""
        known = unit(node)
        text = (node.get("description") or "").strip()
        text = text.removesuffix(f"[{known}]").rstrip() if known else text
        text = text or self._told(node)
        facts = list(_facts(node, known, required))
        listed = "".join(f"<li>{one}</li>" for one in facts)
        inside = self._inside(node)
        told = f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}{inside}"
        return f'### `{name}` {{ #{anchor} }}\n\n{told}\n\n<ul class="facts" markdown="1">{listed}</ul>\n'

    def _told(self, node: Node) -> str:
        names = list(referred(node))
        return (self.definitions[names[0]].get("description") or "").strip() if names else ""

    def _inside(self, node: Node) -> str:
        """Where the tables that a key holds are described."""
        links = []
        for name in referred(node):
            if name in self.places:
                first = self.places[name][0]
                links.append(f"[{first.kind or first.path}]({self.home.get(name, '')}#{first.anchor})")
        return f" Keys: {', '.join(links)}." if links else ""


def _facts(node: Node, known: str | None, required: bool) -> Iterator[str]:
    if required:
        yield "<b>must be given</b>"
    elif node.get("default") is not None:
        yield f"default <b>{_code(value(node['default']))}</b>{f' {known}' if known and known != '-' else ''}"
    elif "default" in node:
        yield "left out by default"
    else:
        yield "default: see the text"
    if known and known != "-" and node.get("default") is None:
        yield f"unit {known}"
    if "symbol" in node:
        yield f"symbol {symbol(node['symbol'])}"
    if "source" in node:
        yield f'source <span class="badge {node["source"]}">{node["source"]}</span>'
    yield f"allowed: {allowed(node)}".replace("`", "")
    slip = magnitude(node)
    if slip:
        yield f"magnitude {slip}"


def _code(text: str) -> str:
    return f"<code>{text}</code>"


def symbol(text: str) -> str:
    """A symbol such as A_p as an equation."""
    return "$" + re.sub(r"_(\w+)", r"_{\1}", text) + "$"


def summary_table(rows: dict[str, tuple[str, Node]]) -> str:
    """Keys at a glance: default, unit, source, each linked to where it is described."""
    sourced = any("source" in node for _, node in rows.values())
    lines = [f"| key | default | unit |{' source |' if sourced else ''}", f"|---|---|---|{'---|' if sourced else ''}"]
    for anchor, (name, node) in rows.items():
        given = node.get("default")
        shown = "" if given is None else f"`{value(given)}`" if len(value(given)) < 40 else "…"
        known = unit(node)
        source = f" {node.get('source', '')} |" if sourced else ""
        lines.append(f"| [`{name}`](#{anchor}) | {shown} | {known if known and known != '-' else ''} |{source}")
    return "\n".join(lines) + "\n"
