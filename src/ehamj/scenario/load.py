"""Read scenarios: TOML files and shipped names, with overrides; file names become absolute."""

import json
from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import ValidationError

from ehamj.control.installation import PARTS, Installation
from ehamj.errors import InputError
from ehamj.scenario.explain import checked
from ehamj.scenario.keys import other_kinds, override, written
from ehamj.scenario.model import Scenario
from ehamj.scenario.places import keys_of
from ehamj.scenario.variation import changed, derived_anew, otherwise, unlike, warn_derived
from ehamj.scenario_files import path_of, scenario_path, scenario_table, shipped_scenarios, table_of
from ehamj.settings import FILE, OVERRIDES, SCENARIO, Settings, schema_of

__all__ = [
    "Given",
    "anchored",
    "as_scenario",
    "changed",
    "check_scenario",
    "load_scenario",
    "named_anew",
    "otherwise",
    "override",
    "parse_scenario",
    "scenario_schema",
    "settings_of",
    "shipped_scenarios",
    "written",
]

S = TypeVar("S", bound=Settings)


def scenario_schema() -> str:
    """JSON schema of a scenario file."""
    return schema_of(Scenario)


def load_scenario(source: str | Path, overrides: Iterable[str] = ()) -> Scenario:
    """Read a scenario.

    Args:
        source: a TOML file, or the name of a shipped scenario.
        overrides: ``a.b=value`` each, applied to the file's content; values are TOML, or else strings. File names in
            them are relative to the working directory.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    found, before = _read(source, overrides)
    _check_law(found, before)
    return found


def check_scenario(source: str | Path, overrides: Iterable[str] = ()) -> None:
    """Refuse what `load_scenario` would, and derive nothing."""
    _read(source, overrides)


def _read(source: str | Path, overrides: Iterable[str]) -> tuple[Scenario, dict[str, Any]]:
    """The scenario, and the table that its file holds."""
    path = scenario_path(source)
    table = anchored(scenario_table(path), Scenario, path.resolve().parent)
    before = deepcopy(table)
    texts = list(overrides)
    for text in texts:
        override(table, text)
    try:
        return parse_scenario(anchored(table, Scenario, Path.cwd())), before
    except InputError as error:
        raise InputError(f"{error}{other_kinds(texts, before, str(error))}") from None


Given = Scenario | str | Path | Mapping[str, Any]
"""What stands for a scenario: one, a shipped name, a file, or its content as nested dictionaries."""


def as_scenario(given: Given) -> Scenario:
    """The scenario that was given, in whatever form.

    Raises:
        InputError: see `load_scenario`, and if it is none of these.
    """
    if isinstance(given, Scenario):
        return given
    if isinstance(given, str | Path):
        return load_scenario(given)
    if isinstance(given, Mapping):
        return parse_scenario(given)
    raise InputError(f"scenario: is a {type(given).__name__}; it must be an ehamj.Scenario, a name or path, or a table")


def _check_law(found: Scenario, before: Mapping[str, Any]) -> None:
    """Warn if overrides changed a machine and, with it, the law that was derived for it."""
    parts = {name: before[name] for name in PARTS if name in before}
    try:
        own = Installation.model_validate(parts)
    except ValidationError:
        return  # without its overrides it was no machine
    if derived_anew(found.control, own, found.installation):
        warn_derived(found.control, unlike(own, found.installation), 3)


def parse_scenario(table: Mapping[str, Any]) -> Scenario:
    """Validate a scenario given as nested dictionaries.

    Raises:
        InputError: see `load_scenario`.
    """
    return checked(Scenario, table)


def settings_of(
    kind: type[S],
    source: str | Path | Mapping[str, Any] | S,
    overrides: Iterable[str],
    shipped: Mapping[str, Path],
    word: str,
) -> S:
    """What a file of some kind of settings states: a study, an identification.

    Args:
        kind: of the settings.
        source: a shipped name, a TOML file, or its content.
        overrides: ``a.b=value`` each, applied to its content, as ``--set`` has them.
        shipped: files that come with ehamj, by name.
        word: what messages call the file.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    if isinstance(source, kind):
        table: dict[str, Any] = json.loads(source.model_dump_json(exclude_unset=True))
    elif isinstance(source, Mapping):
        table = dict(anchored(dict(source), kind, Path.cwd()))
    else:
        assert isinstance(source, str | Path)
        path = path_of(source, shipped, word)
        table = anchored(table_of(path, word), kind, path.resolve().parent)
    for text in overrides:
        override(table, text)
    return checked(kind, anchored(table, kind, Path.cwd()))


def anchored(value: Any, kind: Any, folder: Path) -> Any:
    """``value`` of a field of type ``kind`` with the file names in it absolute, so that it is good from anywhere."""
    return named_anew(value, kind, lambda name: str(folder / name))


def files_of(scenario: Scenario) -> list[str]:
    """Names of the files that a scenario reads; those that ship with ehamj are none."""
    found: list[str] = []

    def kept(name: str) -> str:
        found.append(name)
        return name

    named_anew(scenario.table, Scenario, kept)
    return found


def named_anew(value: Any, kind: Any, name: Callable[[str], str]) -> Any:
    """``value`` of a field of type ``kind`` with each file name in it, absolute or not, as ``name`` has it.

    Which strings are file names the settings say themselves (`ehamj.settings.FileName`); what does not fit its type is
    left as it is. Where several types fit, ``name`` is handed what it gave before.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated and SCENARIO in kind.__metadata__ and isinstance(value, str):
        return value if value in shipped_scenarios() else name(value)
    if origin is Annotated and OVERRIDES in kind.__metadata__:
        return named_anew(value, Scenario, name)
    if origin is Annotated and FILE in kind.__metadata__:
        is_name = isinstance(value, str) and value and not value.startswith("example:")
        return name(value) if is_name else value
    if origin is not Annotated and any(get_origin(part) is Literal and value in get_args(part) for part in parts):
        return value  # a name that is no file's
    if origin in (Annotated, Union, UnionType):
        for part in parts[:1] if origin is Annotated else parts:
            value = named_anew(value, part, name)
    elif origin is tuple and isinstance(value, list):
        return [named_anew(entry, parts[0], name) for entry in value]
    elif origin is dict and isinstance(value, dict):
        return {key: named_anew(entry, parts[1], name) for key, entry in value.items()}
    elif isinstance(kind, type) and issubclass(kind, Settings) and isinstance(value, dict):
        types = keys_of(kind)
        # A variant's table may leave the kind to the scenario; what is a file's name in any kind is one then.
        if "kind" not in types or "kind" not in value or value["kind"] in get_args(types["kind"]):
            return {key: named_anew(entry, types.get(key), name) for key, entry in value.items()}
    return value
