"""What a user writes: a TOML file, validated, completed with defaults, and written back complete."""

import difflib
import json
import tomllib
from collections.abc import Iterable, Mapping
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import tomli_w
from pydantic import Field, ValidationError, model_validator

from ehamj.commands import OpenLoop, Passive
from ehamj.errors import InputError
from ehamj.ground import Motion, Start
from ehamj.ground.records import RecordGround
from ehamj.ground.synthetic import RestGround, SineGround
from ehamj.layout import MOUNTS
from ehamj.parameters import ACTUATOR_PRESETS, DEFAULT_MOUNTS, Actuator, Machine, Mount, Plant, Settings, Supply
from ehamj.signals import Signal

Ground = Annotated[RestGround | SineGround | RecordGround, Field(discriminator="kind")]
Control = Annotated[Passive | OpenLoop, Field(discriminator="kind")]


class Isolator(Actuator):
    """An actuator as a table [actuators.NAME]: a preset and what differs from it."""

    preset: Literal["first-generation", "recommended"] = Field(
        "first-generation", description="where values that are not given come from"
    )

    @model_validator(mode="before")
    @classmethod
    def _fill_from_preset(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or table.get("preset", "first-generation") not in ACTUATOR_PRESETS:
            return table  # the field's own validation says what is allowed
        preset = ACTUATOR_PRESETS[table.get("preset", "first-generation")]
        values = preset.model_dump(exclude={"sources"})
        sources = {k: v for k, v in preset.sources.items() if k not in table or table[k] == values[k]}
        return {**values, **table, "sources": {**sources, **table.get("sources", {})}}


class Output(Settings):
    """What is written beside the numbers."""

    replay: bool = Field(True, description="write replay.rrd")
    exaggeration: float | Literal["auto"] = Field("auto", description="factor on the motions drawn in the replay")


class Scenario(Settings):
    """One simulation, completely described. All values in SI."""

    name: str = Field("unnamed", description="short name", min_length=1)
    description: str = Field("", description="what it is about, one line")
    duration: float = Field(10.0, gt=0, description="simulated time [s]")
    seed: int = Field(0, ge=0, description="seed of everything random")
    gravity: float = Field(9.80665, ge=0, description="gravitational acceleration, downwards [m/s²]")
    timestep: Annotated[float, Field(gt=0)] | Literal["auto"] = Field(
        "auto", description="integration step [s]; auto resolves the fastest mode"
    )
    record_rate: float = Field(1000.0, gt=0, description="rows of the result per second [Hz]")
    plates: Literal["sliding", "tied"] = Field(
        "sliding", description="plates on joints of their own, or as inertia of the stroke coordinates (faster)"
    )
    machine: Machine = Machine()
    mount: tuple[Mount, ...] = Field(DEFAULT_MOUNTS, description="the four mounts")
    actuators: dict[str, Isolator] = Field(
        default_factory=lambda: {"isolator": Isolator()}, description="actuators by name"
    )
    supply: Supply = Supply()
    ground: Ground = RestGround()
    control: Control = Passive()
    output: Output = Output()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = tuple(mount.name for mount in self.mount)
        if sorted(names) != sorted(MOUNTS):
            raise ValueError(f"mount names {list(names)} must be {', '.join(MOUNTS)}, each once")
        half_x, half_y = self.machine.size[0] / 2, self.machine.size[1] / 2
        for mount in self.mount:
            x, y = mount.position
            if abs(x) > half_x or abs(y) > half_y:
                raise ValueError(
                    f"mount {mount.name}: position = [{x:g}, {y:g}] lies outside the machine, "
                    f"which covers ±{half_x:g} by ±{half_y:g} m (machine.size)"
                )
            if mount.actuator not in self.actuators:
                raise ValueError(
                    f"mount {mount.name}: actuator = {mount.actuator!r} must be one of the tables "
                    f"[actuators.NAME]: {', '.join(self.actuators)}"
                )
        at = {mount.name: mount.position for mount in self.mount}
        if not (min(at["front-left"][0], at["front-right"][0]) > max(at["rear-left"][0], at["rear-right"][0])):
            raise ValueError("mount positions: x of the front mounts must be larger than x of the rear mounts")
        if not (min(at["front-left"][1], at["rear-left"][1]) > max(at["front-right"][1], at["rear-right"][1])):
            raise ValueError("mount positions: y of the left mounts must be larger than y of the right mounts")
        return self

    @cached_property
    def _mounts(self) -> tuple[Mount, ...]:
        return tuple(sorted(self.mount, key=lambda mount: MOUNTS.index(mount.name)))

    @property
    def plant(self) -> Plant:
        """The physical part, mounts in order."""
        return Plant(
            machine=self.machine,
            positions=tuple(mount.position for mount in self._mounts),
            actuators=tuple(self.actuators[mount.actuator] for mount in self._mounts),
            supply=self.supply,
            gravity=self.gravity,
            plates=self.plates,
        )

    def motion(self) -> Motion:
        """The ground's motion.

        Raises:
            InputError: if a record cannot be used.
        """
        positions = np.array([mount.position for mount in self._mounts])
        try:
            return self.ground.motion(Start(positions, self.duration, self.seed, Path()))
        except ValueError as error:
            raise InputError(str(error)) from error

    def commands(self) -> tuple[Signal, ...]:
        """The open-loop command of each mount [V]."""
        return self.control.commands()

    def to_toml(self) -> str:
        """The complete scenario as TOML; it runs again to the same result."""
        return tomli_w.dumps(self.model_dump(mode="python", exclude_none=True), multiline_strings=False)


def scenario_schema() -> str:
    """JSON schema of a scenario file."""
    return json.dumps(Scenario.model_json_schema(), indent=2)


def shipped_scenarios() -> dict[str, Path]:
    """Scenarios that come with ehamj, by name."""
    folder = Path(str(resources.files("ehamj"))) / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_scenario(source: str | Path, overrides: Iterable[str] = ()) -> Scenario:
    """Read a scenario.

    Args:
        source: a TOML file, or the name of a shipped scenario.
        overrides: ``a.b=value`` each, applied to the file's content; values are TOML, or else strings.

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
    for override in overrides:
        _override(table, override)
    _anchor_files(table.get("ground"), path.resolve().parent)
    return parse_scenario(table)


def parse_scenario(table: Mapping[str, Any]) -> Scenario:
    """Validate a scenario given as nested dictionaries.

    Raises:
        InputError: see `load_scenario`.
    """
    try:
        return Scenario.model_validate(table)
    except ValidationError as error:
        raise InputError(explain(error)) from None


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
    if not equals or not key.strip():
        raise InputError(f"--set {text!r}: must be key=value, such as machine.mass=4500")
    try:
        parsed = tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        parsed = value.strip()
    *parents, last = key.strip().split(".")
    place: Any = table
    for depth, part in enumerate(parents):
        is_list = isinstance(place, list)
        place = place[_index(place, part, text)] if is_list else place.setdefault(part, {})
        if not isinstance(place, dict | list):
            raise InputError(f"--set {text!r}: {'.'.join(parents[: depth + 1])} is a value, not a table")
    if isinstance(place, list):
        place[_index(place, last, text)] = parsed
    else:
        place[last] = parsed


def _index(place: list[Any], part: str, text: str) -> int:
    if not part.isdigit() or int(part) >= len(place):
        raise InputError(f"--set {text!r}: {part!r} must be an index from 0 to {len(place) - 1}")
    return int(part)


def _anchor_files(ground: Any, folder: Path) -> None:
    """Make the file names of records absolute, so that the resolved scenario runs from anywhere."""
    if not isinstance(ground, dict):
        return
    for key in ("file", "inventory"):
        name = ground.get(key)
        if isinstance(name, str) and not name.startswith("example:"):
            ground[key] = str(folder / name)


def explain(error: ValidationError) -> str:
    """Pydantic's findings as one plain message: key = value: what is allowed."""
    lines = []
    for found in error.errors():
        key = ".".join(str(part) for part in found["loc"] if part not in _KINDS)
        message = found["msg"].removeprefix("Value error, ")
        if found["type"] == "extra_forbidden":
            message = f"unknown key; {_allowed_beside(found['loc'])}"
        elif found["type"] == "missing":
            message = "is missing"
        if found["type"] in ("missing", "value_error") and isinstance(found.get("input"), Mapping):
            lines.append(f"{key}: {message}" if key else message)
        else:
            lines.append(f"{key} = {found.get('input')!r}: {message}")
    return "\n".join(dict.fromkeys(lines))


_KINDS = {"rest", "sine", "record", "passive", "open-loop", "multisine", "step", "chirp", "float", "literal['auto']"}
"""Tags that pydantic puts into a location for unions; no user wrote them."""


def _allowed_beside(location: tuple[int | str, ...]) -> str:
    """The keys that stand where an unknown one was found, nearest first."""
    schema: Any = Scenario.model_json_schema()
    definitions = schema.get("$defs", {})

    def resolve(node: Any, tag: Any) -> Any:
        while "$ref" in node or "oneOf" in node:
            if "oneOf" in node:
                mapping = node["discriminator"]["mapping"]
                node = {"$ref": mapping[tag]} if tag in mapping else {}
            else:
                node = definitions[node["$ref"].rsplit("/", 1)[1]]
        return node

    node = schema
    for position, part in enumerate(location[:-1]):
        node = resolve(node, part)
        if part in node.get("properties", {}):
            node = node["properties"][part]
        elif isinstance(part, int):
            node = node.get("items", {})
        elif "additionalProperties" in node and isinstance(node["additionalProperties"], dict):
            node = node["additionalProperties"]
        node = resolve(node, location[position + 1])
    keys = list(node.get("properties", {}))
    near = difflib.get_close_matches(str(location[-1]), keys, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{hint}allowed: {', '.join(keys)}"
