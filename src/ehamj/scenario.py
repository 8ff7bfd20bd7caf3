"""What a user writes: a TOML file, validated, completed with defaults, and written back complete."""

import difflib
import json
import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import tomli_w
from pydantic import Field, ValidationError, model_validator

from ehamj.commands import OpenLoop, Passive
from ehamj.controllers import LinearController, load_controller
from ehamj.controllers.combined import CombinedSettings
from ehamj.controllers.feedforward import FeedforwardSettings
from ehamj.controllers.modal import ModalSettings
from ehamj.controllers.resonant import ResonantSettings
from ehamj.controllers.sensors import Sensors
from ehamj.controllers.servo import StrokeServoSettings
from ehamj.controllers.skyhook import SkyhookSettings
from ehamj.criteria.response_spectrum import HIGHEST_SHARE
from ehamj.criteria.settings import CriteriaSettings
from ehamj.errors import InputError
from ehamj.forces import Force, Load
from ehamj.forces.settings import check_forces, load_of
from ehamj.ground import Motion, Start
from ehamj.ground.broadband import BroadbandGround, BurstGround
from ehamj.ground.combined import Combined
from ehamj.ground.floors import FloorGround
from ehamj.ground.records import RecordGround
from ehamj.ground.shaped import ShapedGround
from ehamj.ground.synthetic import MultisineGround, RestGround, ShockGround, SineGround, SweepGround
from ehamj.layout import MOUNTS
from ehamj.parameters import (
    ACTUATOR_PRESETS,
    DEFAULT_MOUNTS,
    OILS,
    Actuator,
    Machine,
    Mount,
    Plant,
    Settings,
    Supply,
    Vector3,
)
from ehamj.points import Relative, check_points, check_relatives, default_points
from ehamj.signals import Signal

OneGround = (
    RestGround
    | SineGround
    | MultisineGround
    | SweepGround
    | ShockGround
    | BroadbandGround
    | BurstGround
    | ShapedGround
    | FloorGround
    | RecordGround
)
SingleGround = Annotated[OneGround, Field(discriminator="kind")]


class SumGround(Settings):
    """Several grounds at once."""

    kind: Literal["sum"]
    parts: tuple[SingleGround, ...] = Field(description="grounds that add up", min_length=1)

    def motion(self, start: Start) -> Motion:
        """Build the motion."""
        return Combined(tuple(part.motion(replace(start, part=(k,))) for k, part in enumerate(self.parts)))


Ground = Annotated[OneGround | SumGround, Field(discriminator="kind")]


class Law(Settings):
    """A control law from a file that `ehamj.Controller.save` or `ehamj design` wrote."""

    kind: Literal["law"]
    file: str = Field(description="JSON file of the law, relative to the scenario", min_length=1)

    def controller(self, plant: Plant, sensors: Sensors) -> LinearController:
        """Read the law, or the bank of laws."""
        return load_controller(Path(self.file))

    def commands(self) -> tuple[Signal, ...]:
        """No open-loop command beside the controller's."""
        return Passive().commands()


Control = Annotated[
    Passive
    | OpenLoop
    | FeedforwardSettings
    | StrokeServoSettings
    | SkyhookSettings
    | ModalSettings
    | ResonantSettings
    | CombinedSettings
    | Law,
    Field(discriminator="kind"),
]

VARIANTS: dict[str, Control] = {
    "passive": Passive(),
    "feedforward": FeedforwardSettings(),
    "modal": ModalSettings(),
    "combined": CombinedSettings(),
}
"""Controls that a scenario may be compared with, with their defaults."""


class Isolator(Actuator):
    """An actuator as a table [actuators.NAME]: a preset and what differs from it."""

    preset: Literal["first-generation", "recommended", "elastic-mount", "pneumatic-mount"] = Field(
        "first-generation", description="where values that are not given come from"
    )

    oil: Literal["paper", "mineral", "mineral-aerated", "water-glycol"] = Field(
        "paper", description="sets bulk_modulus, air_fraction and vapour_pressure where they are not given"
    )

    @model_validator(mode="before")
    @classmethod
    def _fill_from_preset(cls, table: Any) -> Any:
        name = table.get("preset", "first-generation") if isinstance(table, Mapping) else None
        if not isinstance(name, str) or name not in ACTUATOR_PRESETS:
            return table  # the field's own validation says what is allowed
        oil = table.get("oil", "paper")
        if not isinstance(oil, str) or oil not in OILS:
            return table
        preset = ACTUATOR_PRESETS[name]
        values = {**preset.model_dump(exclude={"sources"}), **OILS[oil]}
        assumed = dict.fromkeys(OILS[oil], "assumed")
        known = {**preset.sources, **assumed}
        sources = {k: v for k, v in known.items() if k not in table or table[k] == values[k]}
        own = table.get("sources", {})
        return {**values, **table, "sources": {**sources, **own} if isinstance(own, Mapping) else own}


class Output(Settings):
    """What is written beside the numbers."""

    replay: bool = Field(True, description="write replay.rrd")
    report: bool = Field(True, description="write report.html and figures/")
    bookkeeping: bool = Field(False, description="balance oil and energy in states of their own, and report them")
    exaggeration: Annotated[float, Field(gt=0)] | Literal["auto"] = Field(
        "auto", description="factor on the motions drawn in the replay"
    )


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
    compare: tuple[Literal["passive", "feedforward", "modal", "combined"], ...] = Field(
        (), description="variants to run beside it, into folders of their names"
    )
    machine: Machine = Machine()
    mount: tuple[Mount, ...] = Field(DEFAULT_MOUNTS, description="the four mounts")
    actuators: dict[str, Isolator] = Field(
        default_factory=lambda: {"isolator": Isolator()}, description="actuators by name"
    )
    supply: Supply = Supply()
    ground: Ground = RestGround()
    control: Control = Passive()
    points: dict[str, Vector3] = Field(
        {},
        description="points of the machine that are reported, by name: from the mount plane's centre [m]; where the "
        "table is left out, the drawing's spindle nose (assumed)",
    )
    relative: tuple[Relative, ...] = Field((), description="motions of one place relative to another")
    criteria: CriteriaSettings = CriteriaSettings()
    sensors: Sensors = Sensors()
    force: tuple[Force, ...] = Field((), description="forces on the machine itself, which add up")
    output: Output = Output()

    @model_validator(mode="after")
    def _observed(self) -> Self:
        if "points" not in self.model_fields_set:
            object.__setattr__(self, "points", default_points(self.machine))
        check_points(self.points, self.machine)
        check_relatives(self.relative, self.points)
        check_forces(self.force, self.points)
        spectrum = self.criteria.response_spectrum
        if spectrum is not None and spectrum.last > HIGHEST_SHARE * self.record_rate:
            raise ValueError(
                f"criteria.response_spectrum.last = {spectrum.last:g} Hz must be at most record_rate/10 = "
                f"{HIGHEST_SHARE * self.record_rate:g} Hz"
            )
        return self

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
            actuators=tuple(self.actuators[mount.actuator].rated_at(self.supply) for mount in self._mounts),
            supply=self.supply,
            gravity=self.gravity,
            bookkeeping=self.output.bookkeeping,
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

    def load(self) -> Load:
        """The forces on the machine itself."""
        return load_of(self.force, self.points, self.machine.cg, self.duration, self.seed)

    def controller(self) -> LinearController | None:
        """The digital controller, if there is one.

        Raises:
            InputError: if a law cannot be read or run.
        """
        return self.control.controller(self.plant, self.sensors)

    def variant(self, name: str) -> "Scenario":
        """The same scenario under another control, one of `VARIANTS`."""
        return self.model_copy(update={"control": VARIANTS[name], "compare": (), "name": f"{self.name}, {name}"})

    def to_toml(self) -> str:
        """The complete scenario as TOML; it runs again to the same result."""
        return tomli_w.dumps(self.model_dump(mode="python", exclude_none=True), multiline_strings=False)


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
    *parents, last = (part.strip() for part in key.split("."))
    if not equals or not all((*parents, last)):
        raise InputError(f"--set {text!r}: must be key=value, such as machine.mass=4500")
    try:
        parsed = tomllib.loads(f"value = {value}") if "\n" not in value else {}
    except tomllib.TOMLDecodeError:
        parsed = {}
    if parents[:1] == ["mount"]:
        table.setdefault("mount", [mount.model_dump(mode="json") for mount in DEFAULT_MOUNTS])
    place: Any = table
    for depth, part in enumerate(parents):
        is_list = isinstance(place, list)
        place = place[_index(place, part, text)] if is_list else place.setdefault(part, {})
        if not isinstance(place, dict | list):
            raise InputError(f"--set {text!r}: {'.'.join(parents[: depth + 1])} is a value, not a table")
    at = _index(place, last, text) if isinstance(place, list) else last
    place[at] = parsed.get("value", value.strip())
    if isinstance(place, dict) and isinstance(place.get("sources"), dict):
        place["sources"].pop(last, None)  # a resolved scenario states the source of the value that was there before


def _index(place: list[Any], part: str, text: str) -> int:
    if not part.isdigit() or int(part) >= len(place):
        raise InputError(f"--set {text!r}: {part!r} must be an index from 0 to {len(place) - 1}")
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


def explain(error: ValidationError) -> str:
    """Pydantic's findings as one plain message, a line per key: key = value: what is allowed."""
    findings = error.errors()
    inside = {found["loc"][:depth] for found in findings for depth in range(len(found["loc"]))}
    lines: dict[str, list[str]] = {}
    for found in findings:
        if found["type"] == "too_short" and found["loc"] in inside:
            continue  # only because pydantic left out the entry that another finding names
        what, allowed = _finding(found)
        lines.setdefault(what, []).append(allowed)
    return "\n".join(
        f"{what}: {', or '.join(dict.fromkeys(allowed))}".removeprefix(": ") for what, allowed in lines.items()
    )


def _finding(found: Any) -> tuple[str, str]:
    """One finding as ``key = value`` and what is allowed there."""
    location, value, kind, context = found["loc"], found.get("input"), found["type"], found.get("ctx", {})
    key = _key(location)
    message = found["msg"].removeprefix("Value error, ").replace(" after validation", "")
    message = re.sub(r"^(Input|String|Tuple|Dictionary) should (be|have)\b", r"must \2", message)
    if kind == "extra_forbidden":
        message = f"unknown key; {_allowed_beside(location)}"
    elif kind == "union_tag_invalid":
        key, value, message = f"{key}.kind", context["tag"], f"must be one of {context['expected_tags']}"
    elif kind == "union_tag_not_found":
        kinds = _walk(location)[1].get("discriminator", {}).get("mapping", {})
        return f"{key}.kind", f"is missing; must be one of {', '.join(map(repr, kinds))}"
    elif kind in ("model_type", "model_attributes_type", "dict_type"):
        message = "must be a table"
    elif kind == "tuple_type":
        message = "must be a list"
    elif kind == "missing" and isinstance(location[-1], int):
        key, message = _key(location[:-1]), f"entry {location[-1] + 1} is missing"
    elif kind == "missing":
        return key, "is missing"
    elif kind == "value_error" and isinstance(value, Mapping):
        return key, message
    shown = repr(list(value) if isinstance(value, tuple) else value)
    return f"{key} = {shown if len(shown) <= 200 else shown[:200] + '…'}", message


def _allowed_beside(location: tuple[int | str, ...]) -> str:
    """The keys that stand where an unknown one was found, nearest first."""
    keys = list(_walk(location[:-1])[1].get("properties", {}))
    near = difflib.get_close_matches(str(location[-1]), keys, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{hint}allowed: {', '.join(keys)}"


def _key(location: tuple[int | str, ...]) -> str:
    return ".".join(_walk(location)[0])


@cache
def _schema() -> dict[str, Any]:
    return Scenario.model_json_schema()


def _walk(location: tuple[int | str, ...]) -> tuple[list[str], dict[str, Any]]:
    """Where a location leads: the keys as the user wrote them (without the tags of unions), and the schema there."""
    schema = _schema()
    keys: list[str] = []
    node: Any = schema
    for part in location:
        if "discriminator" in node:
            node = {"$ref": node["discriminator"]["mapping"][part]}
        elif "anyOf" in node:
            node = {}
        else:
            keys.append(str(part))
            further = node.get("items" if isinstance(part, int) else "additionalProperties", {})
            node = node.get("properties", {}).get(part, further) or {}
        choices = [choice for choice in node.get("anyOf", []) if choice != {"type": "null"}]
        node = choices[0] if len(choices) == 1 else node  # what may be left out has one real choice
        while "$ref" in node:
            node = schema["$defs"][node["$ref"].rsplit("/", 1)[1]]
    return keys, node
