"""Scenarios by chance: valid ones of all kinds, and shipped or valid ones that are mutated."""

import math
import re
from copy import deepcopy
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import tomli_w
from oracles.damage import damaged

from ehamj.bounds import unit_of
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.model import Scenario
from ehamj.scenario.places import by_kind, choices, inside, keys_of, only
from ehamj.scenario_files import scenario_table, shipped_scenarios
from ehamj.settings import PROVENANCE, Settings
from fuzz.case import Case
from fuzz.together import FILES, HOOKS, LEVELS, law_file
from fuzz.values import DEEP, HUGE, Drawer, wild

OFF = {"replay": False, "report": False}
RUN = ("run", "x.toml", "--out", "out", "--json")
RARE = {"LqgSettings": 0.05, "HInfinitySettings": 0.02, "RecordGround": 0.5, "SumGround": 0.7}
"""Kinds that take seconds."""


def drawn(random: Random) -> tuple[dict[str, Any], dict[str, bytes]]:
    """A scenario as its types allow it, and the files that it names."""
    draw = Drawer(random, HOOKS)
    draw.weights = RARE
    mounts = _mounts(random)
    names = [mount["name"] for mount in mounts] if mounts else list(MOUNTS)
    draw.names = {"mount": names, "mounts": names, "point": ["cg"], "level": LEVELS, "actuator": ["isolator"]}
    table = {"name": f"drawn-{draw.word()}", "duration": random.choice([0.01, 0.02, 0.03, 0.05])}
    types, fields = keys_of(Scenario), Scenario.model_fields
    table |= {"mount": mounts} if mounts else {}
    drawn_at = {
        "engine": 0.3, "plates": 0.3, "gravity": 0.1, "record_rate": 0.3, "seed": 0.5, "machine": 0.7, "part": 0.3,
        "slide": 0.25, "actuators": 0.6, "supply": 0.3, "sensors": 0.5, "ground": 0.9, "control": 0.85, "relative": 0.2,
        "criteria": 0.3, "force": 0.4, "fault": 0.3,
    }  # fmt: skip
    for key, share in drawn_at.items():
        if random.random() < share:
            table[key] = draw.value(types[key], key, fields[key])
    if "actuators" in table:
        table["actuators"] = {"isolator": draw.table(_isolator(), random.choice([0.03, 0.15]))}
    for key in ("part", "slide", "relative"):
        for number, entry in enumerate(table.get(key, ())):
            entry["name"] = f"{key}{number}"
    if "record_rate" in table:
        table["record_rate"] = random.choice([500.0, 1000.0, 2000.0, 5000.0])
    if random.random() < 0.1:
        table["points"] = {"tool": [0.1, 0.2, 1.0]}
    if random.random() < 0.1:
        table["compare"] = ["passive"]
    shown = random.random() < 0.02
    table["output"] = {"report": shown, "replay": shown and random.random() < 0.5}
    if random.random() < 0.1:
        table["output"]["bookkeeping"] = True
    files = {name: content.encode() for name, content in FILES.items()}
    files["law.json"] = law_file(names, -8.7e3 * random.uniform(0.5, 1.1)).encode()
    return table, files


def _isolator() -> type[Settings]:
    """The settings of an isolator."""
    return next(one for one in choices(inside(keys_of(Scenario)["actuators"], "isolator")) if issubclass(one, Settings))


def _mounts(random: Random) -> list[dict[str, Any]]:
    """Feet around the machine, now and then one that acts level; none for the default ones."""
    if random.random() < 0.6:
        return []
    count = random.randint(3, 6)
    begin = random.uniform(0, math.tau)
    found: list[dict[str, Any]] = []
    for k in range(count):
        angle = begin + math.tau * k / count
        place = [0.9 * math.cos(angle), 0.7 * math.sin(angle), random.choice([0.0, 0.0, 0.1])]
        found.append({"name": f"m{k}", "position": [round(one, 3) for one in place]})
        if random.random() < 0.1:
            found[-1]["height"] = random.uniform(-1e-4, 1e-4)
    if random.random() < 0.3:
        found.append({"name": "side", "position": [0.0, 0.7, 0.7], "direction": [0.0, 1.0, 0.0]})
    return found


def valid(random: Random, kept: Path) -> Case:
    """A valid scenario: it ends whole, or is refused by a key, or fails and is kept as such."""
    table, files = drawn(random)
    return Case({"x.toml": text_of(table), **files}, (RUN,), told="drawn from the schema")


def base(random: Random) -> tuple[dict[str, Any], dict[str, bytes]]:
    """A shipped scenario or a valid one, short, quick to derive, and without pages."""
    if random.random() < 0.5:
        return drawn(random)
    path = random.choice(sorted(shipped_scenarios().values()))
    table = scenario_table(path) | {"duration": 0.02, "compare": [], "output": dict(OFF)}
    if table.get("control", {}).get("kind") in ("lqg", "h-infinity") and random.random() < 0.95:
        table["control"] = {"kind": random.choice(["combined", "feedforward", "modal", "passive"])}
    if table.get("ground", {}).get("kind") == "record" and random.random() < 0.8:
        table["ground"] = {"kind": "broadband"}
    return table, {name: content.encode() for name, content in FILES.items()}


def mutated(random: Random, kept: Path) -> Case:
    """A scenario with some of it as it must not be."""
    table, files = base(random)
    changed, told = [], []
    text = random.random()
    for _ in range(0 if text < 0.1 else random.choice([1, 1, 1, 2, 3])):
        key, how = random.choice(WAYS)(random, table)
        changed.append(key)
        told.append(f"{how} {key}")
    content = text_of(table)
    if text < 0.15:
        content, how = _other_text(random, content)
        told.append(how)
    command = random.choice(
        [RUN, RUN, RUN, RUN, RUN, RUN, ("modes", "x.toml", "--json"), ("statics", "x.toml", "--json")]
    )
    return Case({"x.toml": content, **files}, (command,), tuple(changed), "; ".join(told), damaged=text < 0.15)


def text_of(table: dict[str, Any]) -> bytes:
    """TOML of a table, with what no writer of it writes."""
    text = tomli_w.dumps(table)
    text = text.replace(f'"{DEEP}"', "[" * 3000 + "]" * 3000).replace(f'"{HUGE}"', "9" * 400)
    return text.encode("utf-8", "surrogateescape")


Step = str | int
Found = tuple[str, str]


def _places(node: Any, before: tuple[Step, ...] = ()) -> list[tuple[Step, ...]]:
    """Where anything stands in nested tables and lists."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    found = []
    for key, value in items:
        found += [(*before, key), *_places(value, (*before, key))]
    return found


def _at(node: Any, place: tuple[Step, ...]) -> Any:
    for step in place:
        node = node[step]
    return node


def _pick(random: Random, table: dict[str, Any]) -> tuple[Any, Step, str]:
    """A container, a key in it, and the dotted key."""
    place = random.choice(_places(table))
    return _at(table, place[:-1]), place[-1], ".".join(map(str, place))


def _unit(key: str, kind: Any = Scenario) -> str | None:
    """The unit of what stands under a dotted key."""
    unit = None
    for part in key.split("."):
        settings = only(kind) if kind is not None and not isinstance(kind, type) else kind
        if isinstance(settings, type) and issubclass(settings, Settings):
            field = next((f for n, f in settings.model_fields.items() if (f.alias or n) == part), None)
            unit = unit_of(field.description) if field is not None else None
        kind = inside(settings, int(part) if part.isdigit() else part) if kind is not None else None
    return unit


def _other_value(random: Random, table: dict[str, Any]) -> Found:
    holder, key, name = _pick(random, table)
    holder[key] = wild(random, deepcopy(holder[key]), _unit(name))
    return name, "another value of"


def _any_key(random: Random, table: dict[str, Any]) -> Found:
    """A key anywhere in the schema, with a value that may be anything."""
    kind: Any = Scenario
    at, name = table, ""
    draw = Drawer(random, HOOKS)
    draw.names = {"mount": list(MOUNTS), "mounts": list(MOUNTS), "point": ["cg"], "level": LEVELS}
    while True:
        keys = keys_of(kind)
        key = random.choice([one for one in keys if one not in PROVENANCE])
        name = f"{name}.{key}".removeprefix(".")
        field = next(f for n, f in kind.model_fields.items() if (f.alias or n) == key)
        tables = list(by_kind(keys[key]).values()) or [one for one in [only(keys[key])] if _is_table(one)]
        if not tables or random.random() < 0.15:
            value = draw.value(keys[key], key, field)
            unit = unit_of(field.description)
            at[key] = wild(random, value, unit) if random.random() < 0.85 else value
            return name, "a value of the schema's"
        inner = at.get(key)
        stated = by_kind(keys[key]).get(inner.get("kind", "")) if isinstance(inner, dict) and tables[1:] else None
        kind = stated or random.choice(tables)
        if not isinstance(inner, dict) or (tables[1:] and stated is None):
            inner = at[key] = draw.table(kind)
        at = inner


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Settings)


def _drop(random: Random, table: dict[str, Any]) -> Found:
    holder, key, name = _pick(random, table)
    del holder[key]
    return name, "without"


def _rename(random: Random, table: dict[str, Any]) -> Found:
    holder, key, name = _pick(random, table)
    if isinstance(holder, list):
        return _other_value(random, table)
    other = random.choice([f"{key}s", str(key)[:-1], str(key).upper(), f"{key}.x", "", f"{key}_1", "ключ", "a" * 3000])
    holder[other] = holder.pop(key)
    return f"{name} {other}", "renamed"


def _move(random: Random, table: dict[str, Any]) -> Found:
    holder, key, name = _pick(random, table)
    value = deepcopy(holder[key])
    other, there, where = _pick(random, table)
    other[there] = value
    return f"{name} {where}", "copied"


def _again(random: Random, table: dict[str, Any]) -> Found:
    """An entry of a list twice."""
    lists = [place for place in _places(table) if isinstance(_at(table, place), list) and _at(table, place)]
    if not lists:
        return _any_key(random, table)
    place = random.choice(lists)
    found = _at(table, place)
    found.append(deepcopy(random.choice(found)))
    return ".".join(map(str, place)), "doubled in"


WAYS = (_other_value, _other_value, _any_key, _any_key, _any_key, _drop, _rename, _move, _again)


def _other_text(random: Random, content: bytes) -> tuple[bytes, str]:
    """The bytes of a file with damage, and what it is."""
    lines = content.split(b"\n")
    how = random.randrange(6)
    if how == 0:
        return content[: random.randrange(len(content))], "cut"
    if how == 1:
        k = random.randrange(len(lines))
        return b"\n".join([*lines[:k], lines[k], *lines[k:]]), f"line {k + 1} twice"
    if how == 2:
        return content.decode().encode(random.choice(["utf-16", "utf-32", "cp037"]), "replace"), "in another encoding"
    if how == 3:
        k = random.randrange(len(content))
        return content[:k] + random.choice([b"\xff", b"\xc3", b"\x00", b"\xed\xa0\x80", b"\r"]) + content[
            k:
        ], "a strange byte"
    if how == 4:
        numbers = list(re.finditer(rb"(?<=[\s=\[])\d[\d.]*", content))
        if numbers:
            at = random.choice(numbers)
            text = random.choice(
                [b"0x1F", b"1_0", b"00", b"1e", b"+nan", b"1979-05-27", b"1.", b"--1", b'"""', b"1e400"]
            )
            return content[: at.start()] + text + content[at.end() :], f"{text.decode()} in place of a number"
    return damaged(content, np.random.default_rng(random.randrange(2**32)), 200, texts=True), "bytes damaged"
