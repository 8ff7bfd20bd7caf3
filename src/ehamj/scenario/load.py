"""Read scenarios: TOML files and shipped names, with overrides; file names become absolute."""

import json
import math
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from ehamj.errors import InputError
from ehamj.plain.text import text_of, toml_of
from ehamj.plant.mounts import DEFAULT_MOUNTS
from ehamj.scenario.explain import checked
from ehamj.scenario.model import Scenario
from ehamj.settings import FILE, Settings


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
        table = toml_of(text_of(path))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"scenario {path}: cannot be read ({error})") from error
    except ValueError as error:
        raise InputError(f"scenario {path}: not valid TOML: {error}") from error
    table = anchored(table, Scenario, path.resolve().parent)
    for text in overrides:
        override(table, text)
    return parse_scenario(anchored(table, Scenario, Path.cwd()))


def parse_scenario(table: Mapping[str, Any]) -> Scenario:
    """Validate a scenario given as nested dictionaries.

    Raises:
        InputError: see `load_scenario`.
    """
    return checked(Scenario, table)


def changed(scenario: Scenario, values: Mapping[str, Any]) -> Scenario:
    """The scenario with other values, checked as a file is.

    Args:
        scenario: what they differ from.
        values: by dotted key, as ``--set`` has them: ``{"control.delay": 3e-4, "mount.0.actuator": "soft"}``; a whole
            table replaces the one that is there.

    Raises:
        InputError: see `load_scenario`.
    """
    table = _listed(scenario.model_dump(mode="python", exclude_none=True))
    if "points" not in scenario.model_fields_set:
        del table["points"]  # they follow the machine's size
    for key, value in values.items():
        _place(table, key, _listed(value), f"{key} = {value!r}")
    return parse_scenario(table)


def override(table: dict[str, Any], text: str) -> None:
    """Put ``key=value`` into a scenario's table: a dotted key, and a TOML value or else a string.

    Raises:
        InputError: if it has not that form, or the key leads nowhere.
    """
    key, equals, value = text.partition("=")
    said = f"--set {text!r}"
    if not equals or not all(part.strip() for part in key.split(".")):
        raise InputError(f"{said}: must be key=value, such as machine.mass=4500")
    _place(table, key, written(value), said)


def written(text: str) -> Any:
    """The value of what a user wrote: TOML, or else a string."""
    try:
        return toml_of(f"value = {text}")["value"] if "\n" not in text else text.strip()
    except ValueError:
        return text.strip()


def _place(table: dict[str, Any], key: str, value: Any, said: str) -> None:
    """Set the value of a dotted key; ``said`` is what messages begin with."""
    *parents, last = (part.strip() for part in key.split("."))
    if parents[:1] == ["mount"]:
        table.setdefault("mount", [mount.model_dump(mode="json") for mount in DEFAULT_MOUNTS])
    place: Any = table
    for depth, part in enumerate(parents):
        place = place[_index(place, part, said)] if isinstance(place, list) else place.setdefault(part, {})
        if not isinstance(place, dict | list):
            raise InputError(f"{said}: {'.'.join(parents[: depth + 1])} is a value, not a table")
    at = _index(place, last, said) if isinstance(place, list) else last
    place[at] = value
    if isinstance(place, dict) and isinstance(place.get("sources"), dict):
        place["sources"].pop(last, None)  # a resolved scenario states the source of the value that was there before


def _index(place: list[Any], part: str, said: str) -> int:
    if not part.isdigit() or int(part) >= len(place):
        raise InputError(f"{said}: {part!r} must be an index from 0 to {len(place) - 1}")
    return int(part)


def _listed(value: Any) -> Any:
    """The value as TOML would give it: lists for tuples."""
    if isinstance(value, Mapping):
        return {key: _listed(entry) for key, entry in value.items()}
    return [_listed(entry) for entry in value] if isinstance(value, tuple | list) else value


def _find(source: str | Path) -> Path:
    shipped = shipped_scenarios()
    if str(source) in shipped:
        return shipped[str(source)]
    path = Path(source)
    if not path.is_file():
        raise InputError(f"scenario {str(source)!r}: no such file, and the shipped ones are {', '.join(shipped)}")
    return path


def anchored(value: Any, kind: Any, folder: Path) -> Any:
    """``value`` of a field of type ``kind`` with the file names in it absolute, so that it is good from anywhere.

    Which strings are file names the settings say themselves (`ehamj.settings.FileName`); what does not fit its type is
    left as it is.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated and FILE in kind.__metadata__:
        is_name = isinstance(value, str) and value and not value.startswith("example:")
        return str(folder / value) if is_name else value
    if origin is not Annotated and any(get_origin(part) is Literal and value in get_args(part) for part in parts):
        return value  # a name that is no file's
    if origin in (Annotated, Union, UnionType):
        for part in parts[:1] if origin is Annotated else parts:
            value = anchored(value, part, folder)
    elif origin is tuple and isinstance(value, list):
        return [anchored(entry, parts[0], folder) for entry in value]
    elif origin is dict and isinstance(value, dict):
        return {key: anchored(entry, parts[1], folder) for key, entry in value.items()}
    elif isinstance(kind, type) and issubclass(kind, Settings) and isinstance(value, dict):
        types = get_type_hints(kind, include_extras=True)
        if "kind" not in types or value.get("kind") in get_args(types["kind"]):
            return {key: anchored(entry, types.get(key), folder) for key, entry in value.items()}
    return value
