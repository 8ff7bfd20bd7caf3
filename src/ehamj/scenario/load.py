"""Read scenarios: TOML files and shipped names, with overrides; file names become absolute."""

import json
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from ehamj.errors import InputError
from ehamj.plant.mounts import DEFAULT_MOUNTS
from ehamj.scenario.explain import checked
from ehamj.scenario.model import Scenario


def scenario_schema() -> str:
    """JSON schema of a scenario file; defaults that JSON has no number for (infinity) are left out."""

    def finite(node: Any) -> Any:
        if isinstance(node, dict):
            return {k: finite(v) for k, v in node.items() if not (isinstance(v, float) and math.isinf(v))}
        return [finite(entry) for entry in node] if isinstance(node, list) else node

    return json.dumps(finite(Scenario.model_json_schema()), indent=2, allow_nan=False)


def shipped_scenarios() -> dict[str, Path]:
    """Scenarios that come with ehamj, by name."""
    folder = Path(str(resources.files("ehamj"))) / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_scenario(source: str | Path, overrides: Iterable[str] = ()) -> Scenario:
    """Read a scenario.

    Args:
        source: a TOML file, or the name of a shipped scenario.
        overrides: ``a.b=value`` each, applied to the file's content; values are TOML, or else strings. File names in
            them are relative to the working directory.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    path = _find(source)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"scenario {path}: cannot be read ({error})") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"scenario {path}: not valid TOML: {error}") from error
    for part in ("ground", "control"):
        _anchor_files(table.get(part), path.resolve().parent)
    for override in overrides:
        _override(table, override)
    for part in ("ground", "control"):
        _anchor_files(table.get(part), Path.cwd())
    return parse_scenario(table)


def parse_scenario(table: Mapping[str, Any]) -> Scenario:
    """Validate a scenario given as nested dictionaries.

    Raises:
        InputError: see `load_scenario`.
    """
    return checked(Scenario, table)


def _find(source: str | Path) -> Path:
    shipped = shipped_scenarios()
    if str(source) in shipped:
        return shipped[str(source)]
    path = Path(source)
    if not path.is_file():
        raise InputError(f"scenario {str(source)!r}: no such file, and the shipped ones are {', '.join(shipped)}")
    return path


def _override(table: dict[str, Any], text: str) -> None:
    key, equals, value = text.partition("=")
    if not equals or not all(part.strip() for part in key.split(".")):
        raise InputError(f"--set {text!r}: must be key=value, such as machine.mass=4500")
    table.update(replaced(table, key, written(value), f"--set {text!r}"))


def written(text: str) -> Any:
    """The value of a text that a user wrote: TOML, or else a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"] if "\n" not in text else text.strip()
    except tomllib.TOMLDecodeError:
        return text.strip()


def replaced(table: Mapping[str, Any], key: str, value: Any, named: str) -> dict[str, Any]:
    """A scenario's table with another value at a dotted key; messages call the change ``named``.

    Raises:
        InputError: if the key leads through a value, or to no entry of a list.
    """
    path = [part.strip() for part in key.split(".")]
    if path[0] == "mount" and len(path) > 1 and "mount" not in table:
        table = {**table, "mount": [mount.model_dump(mode="json") for mount in DEFAULT_MOUNTS]}
    found: dict[str, Any] = _replaced(table, path, value, named, 0)
    return found


def _replaced(node: Any, path: list[str], value: Any, named: str, depth: int) -> Any:
    if depth == len(path):
        return value
    part = path[depth]
    if isinstance(node, Sequence) and not isinstance(node, str):
        at = _index(node, part, named)
        entry = _replaced(node[at], path, value, named, depth + 1)
        return [*node[:at], entry, *node[at + 1 :]]
    if not isinstance(node, Mapping):
        raise InputError(f"{named}: {'.'.join(path[:depth])} is a value, not a table")
    found = {**node, part: _replaced(node.get(part, {}), path, value, named, depth + 1)}
    if depth == len(path) - 1 and isinstance(node.get("sources"), Mapping):
        # A resolved scenario states the source of the value that was there before.
        found["sources"] = {name: source for name, source in node["sources"].items() if name != part}
    return found


def _index(place: Sequence[Any], part: str, named: str) -> int:
    if not part.isdigit() or int(part) >= len(place):
        raise InputError(f"{named}: {part!r} must be an index from 0 to {len(place) - 1}")
    return int(part)


def _anchor_files(ground: Any, folder: Path) -> None:
    """Make the file names of records absolute, so that the resolved scenario runs from anywhere."""
    if not isinstance(ground, dict):
        return
    for part in ground.get("parts", []) if isinstance(ground.get("parts"), list) else []:
        _anchor_files(part, folder)
    _anchor_files(ground.get("target"), folder)
    for key in ("file", "inventory"):
        name = ground.get(key)
        if isinstance(name, str) and name and not name.startswith("example:"):
            ground[key] = str(folder / name)
