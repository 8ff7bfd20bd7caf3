"""The tables of a file of settings as pages: every key once, with an anchor of its own."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ehamj.settings import PROVENANCE, Settings, schema_of
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
        parts = [f"# {title}\n\n{intro}\n", self._kinds(sections), self._shared_sections(keys[0], shared)]
        parts += [self._section(name, place, shared, keys[0]) for name, place in sections]
        return "\n".join(parts)

    def _kinds(self, sections: list[tuple[str, Place]]) -> str:
        """The kinds that there are, where there are any."""
        kinds = [(place, self._told(name)) for name, place in sections if place.kind]
        lines = [f"| [`{place.kind}`](#{place.anchor}) | `[{place.path}]` | {first(told)} |" for place, told in kinds]
        return "\n".join(["| kind | of | what it is |", "|---|---|---|", *lines, ""]) if lines else ""

    def _shared(self, names: list[str]) -> dict[str, tuple[Node, list[str]]]:
        """Keys that several kinds have alike, with the kinds."""
        found: dict[str, list[tuple[Node, str]]] = {}
        for name in names:
            for key, node in self.definitions[name]["properties"].items():
                if key not in ("kind", "name", *PROVENANCE):
                    found.setdefault(key, []).append((node, self.places[name][0].kind or ""))
        alike = {key: [kind for node, kind in have if node == have[0][0]] for key, have in found.items()}
        return {key: (found[key][0][0], kinds) for key, kinds in alike.items() if len(kinds) >= SHARED_BY}

    def _shared_sections(self, path: str, shared: dict[str, tuple[Node, list[str]]]) -> str:
        """Such keys, those of the same kinds together."""
        groups: dict[tuple[str, ...], list[str]] = {}
        for key, (_, kinds) in shared.items():
            groups.setdefault(tuple(kinds), []).append(key)
        parts = []
        for number, (having, keys) in enumerate(groups.items(), 1):
            title = f"## Keys of {len(having)} kinds {{ #{path}.shared-{number} }}\n"
            parts += [title, f"{', '.join(f'`{kind}`' for kind in having)}\n"]
            parts += [self.key(key, shared[key][0], f"{path}.{key}", False) for key in keys]
        return "\n".join(parts)

    def _section(self, name: str, place: Place, shared: dict[str, Any], key: str) -> str:
        definition = self.definitions[name]
        parts = [f"## {place.heading} {{ #{place.anchor} }}\n", f"{self._said(name)}\n"]
        others = [one.heading for one in self.places[name][1:]]
        if others:
            parts.append(f"The same keys: {', '.join(others)}.\n")
        elsewhere = [one for one, (_, kinds) in shared.items() if place.kind in kinds]
        left = {*elsewhere, "kind", *PROVENANCE}
        here = {one: node for one, node in definition.get("properties", {}).items() if one not in left}
        required = definition.get("required", ())
        if len(here) > 3:
            parts.append(summary_table({f"{place.anchor}.{one}": (one, node) for one, node in here.items()}))
        if elsewhere:
            links = ", ".join(f"[`{one}`](#{key}.{one})" for one in elsewhere)
            parts.append(f"As other kinds have them: {links}.\n")
        parts += [self.key(one, node, f"{place.anchor}.{one}", one in required) for one, node in here.items()]
        return "\n".join(parts)

    def _said(self, name: str) -> str:
        """What a table is, in the words of the settings."""
        return literal((self.definitions[name].get("description") or "").strip())

    def key(self, name: str, node: Node, anchor: str, required: bool) -> str:
        """One key: a heading that search finds, what it means, and its facts."""
        known = unit(node)
        text = (node.get("description") or "").strip()
        text = literal(text.removesuffix(f"[{known}]").rstrip() if known else text) or self._told(node)
        told = f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}{self._inside(node)}"
        facts = " · ".join(_facts(node, known, required))
        return f"### `{name}` {{ #{anchor} }}\n\n{told}\n\n{facts}\n{{ .facts }}\n"

    def _told(self, node: Node | str) -> str:
        names = [node] if isinstance(node, str) else list(referred(node))
        return self._said(names[0]) if names else ""

    def _inside(self, node: Node) -> str:
        """Where the tables that a key holds are described."""
        links = []
        for name in referred(node):
            if name in self.places:
                at = self.places[name][0]
                links.append(f"[`{at.kind or at.path}`]({self.home.get(name, '')}#{at.anchor})")
        return f" Keys of it: {', '.join(links)}." if links else ""


def literal(text: str) -> str:
    """Words of the settings, none of which is meant as Markdown."""
    return re.sub(r"([*_\[\]<>|$])", r"\\\1", text.replace("``", "`")) if "`" not in text else text.replace("``", "`")


def first(text: str) -> str:
    """The first sentence."""
    return re.split(r"(?<=[a-z)])\. |\n\n|: ", text)[0].rstrip(".").replace("\n", " ")


def _facts(node: Node, known: str | None, required: bool) -> Iterator[str]:
    default = node.get("default")
    endless = "default" not in node and node.get("type") == "number"  # infinity, for which JSON has no number
    of = f" {known}" if known and known != "-" else ""
    if required:
        yield f"**must be given**{of and f', in{of}'}"
    elif default is not None or endless:
        yield f"default **`{'inf' if default is None else value(default)}`**{of}"
    else:
        yield f"may be left out{of and f'; in{of}'}"
    if "symbol" in node:
        yield f"symbol {symbol(node['symbol'])}"
    if "source" in node:
        yield f'source <span class="badge {node["source"]}">{node["source"]}</span>'
    yield f"allowed: {allowed(node)}"
    slip = magnitude(node)
    if slip:
        yield f"magnitude {slip}"


def symbol(text: str) -> str:
    """A symbol such as A_p as an equation."""
    return "$" + re.sub(r"_(\w+)", r"_{\1}", text.replace("−", "^{-}").replace("+", "^{+}")) + "$"


def summary_table(rows: dict[str, tuple[str, Node]]) -> str:
    """Keys at a glance: default, unit, source, each linked to where it is described."""
    sourced = any("source" in node for _, node in rows.values())
    lines = [f"| key | default | unit |{' source |' if sourced else ''}", f"|---|---|---|{'---|' if sourced else ''}"]
    for anchor, (name, node) in rows.items():
        given = node.get("default")
        endless = "default" not in node and node.get("type") == "number"
        text = value(given) if given is not None else "inf" if endless else ""
        shown = f"`{text}`" if 0 < len(text) < 40 else "…" if text else ""
        known = unit(node)
        source = f" {node.get('source', '')} |" if sourced else ""
        lines.append(f"| [`{name}`](#{anchor}) | {shown} | {known if known and known != '-' else ''} |{source}")
    return "\n".join(lines) + "\n"


def pages_of(
    kind: type[Settings], folder: str, head: str, said: str, titles: Mapping[str, tuple[str, str]]
) -> dict[str, str]:
    """Pages of every key of a kind of file, one for each of its tables, as Markdown by path within the site.

    Args:
        kind: of settings that the file holds.
        folder: of the pages, below ``reference``.
        head: title of their index.
        said: what the index begins with.
        titles: title and first sentence of each table's page, by its key.
    """
    tables = Tables(json.loads(schema_of(kind)))
    pages = {f"{key}.md": tables.page(title, first, f"{key}.md", [key]) for key, (title, first) in titles.items()}
    properties, required = tables.schema["properties"], tables.schema.get("required", ())
    parts = [
        f"# {head}\n",
        f"{said}\n",
        summary_table({name: (name, node) for name, node in properties.items()}),
        *(tables.key(name, node, name, name in required) for name, node in properties.items()),
    ]
    return {f"reference/{folder}/{name}": text for name, text in {"index.md": "\n".join(parts), **pages}.items()}
