"""What everything that a user writes is made of: frozen, validated, in SI, each physical value with its source.

A source is one of

- ``paper``: Table I or the text of the source paper,
- ``identified``: fitted to measurements, or to something that the paper states; what was fitted to measurements has its
  standard deviation in ``deviations``,
- ``assumed``: chosen, because nobody measured it,
- ``given``: set by the user.
"""

import json
import math
import operator
from collections.abc import Collection, Iterable, Mapping
from functools import partial
from typing import Annotated, Any, Final, Literal, Self, Union, get_args, get_origin

from annotated_types import Gt
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from ehamj.bounds import check_count, check_magnitude, unit_of

Source = Literal["paper", "identified", "assumed", "given"]
Vector3 = tuple[float, float, float]


def _has_length(direction: Vector3) -> Vector3:
    if math.hypot(*direction) < 1e-9:
        raise ValueError(f"{list(direction)} has no length; along x it is [1, 0, 0], up it is [0, 0, 1]")
    return direction


def unit(direction: Vector3) -> Vector3:
    """A direction at length one."""
    length = math.hypot(*direction)
    x, y, z = (entry / length for entry in direction)
    return (x, y, z)


Direction = Annotated[Vector3, AfterValidator(_has_length)]
"""x, y, z of any length but none; see `unit`."""
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
SHORTEST_FADE: Final = 1e-9
"""[s]"""


def _rises(band: tuple[float, float]) -> tuple[float, float]:
    if not band[0] < band[1]:
        raise ValueError("the first must be below the second")
    return band


def _lasts(fade: float) -> float:
    if 0.0 < fade < SHORTEST_FADE:
        raise ValueError(f"must be zero or at least {SHORTEST_FADE:g} s")
    return fade


Band = Annotated[tuple[Positive, Positive], AfterValidator(_rises)]
"""Lowest and highest frequency [Hz]."""

Fade = Annotated[float, Field(ge=0), AfterValidator(_lasts)]
"""Time over which something fades; at once, 0, or in a time that its rate of change does not suffer from [s]."""
Deviation = NotNegative | tuple[NotNegative, ...] | tuple[tuple[NotNegative, ...], ...]
"""Standard deviation of a value, of the value's own shape and unit; zero for an entry that was not fitted."""
PROVENANCE: Final = ("sources", "deviations")
"""Keys beside physical values that say where these come from and how well they are known; they are no values."""
Unlimited = Annotated[float, Field(allow_inf_nan=True)]

FILE = "file"
FileName = Annotated[str, FILE]
"""Name of a file that belongs to the scenario: relative to its folder as written, absolute once it is read."""
SCENARIO = "scenario"
"""Marks a field that may hold the name of another scenario: a shipped one's, or a file's as `FileName`."""

OVERRIDES = "overrides"
"""Marks a table that holds what of its scenario is otherwise."""


def _holds_floats(kind: Any) -> bool:
    """Whether a type is that of numbers, or of lists or tables of them."""
    return kind is float or any(_holds_floats(part) for part in get_args(kind))


def _holds_many(kind: Any) -> bool:
    """Whether a type is that of a list or a table of as many entries as one likes."""
    parts = get_args(kind)
    return (get_origin(kind) in (tuple, dict) and (Ellipsis in parts or get_origin(kind) is dict)) or any(
        _holds_many(part) for part in parts
    )


class _Bounded(AfterValidator):
    """What `ehamj.bounds` checks of a field."""


class Settings(BaseModel):
    """Base of everything a user writes: frozen, no unknown keys, no conversion of types (a string or ``true`` is not a
    number), finite numbers unless a field says otherwise."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, allow_inf_nan=False, strict=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Bound every number by what its unit can have, and how many there are; validators are built later, with what
        stands here."""
        super().__pydantic_init_subclass__(**kwargs)
        for field in cls.model_fields.values():
            if not any(isinstance(one, _Bounded) for one in field.metadata):
                least = any(isinstance(one, Gt) for one in field.metadata)
                unit = unit_of(field.description) or ("-" if _holds_floats(field.annotation) else None)
                own = {"unit": unit, "endless": field.default == math.inf, "signed": not least}
                field.metadata.append(_Bounded(partial(check_magnitude, **own)))
                if _holds_many(field.annotation):
                    field.metadata.append(BeforeValidator(check_count))

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with other values, not checked; what the settings have computed of themselves stays behind."""
        made = super().model_copy(update=update, deep=deep)
        for name in made.__dict__.keys() - type(self).model_fields.keys():
            del made.__dict__[name]
        return made

    def __eq__(self, other: object) -> bool:
        """Whether both are of one kind and have equal values, whatever they have computed of themselves: a cached array
        has no one truth."""
        if not isinstance(other, Settings):
            return NotImplemented
        if type(self) is not type(other):
            return False
        ours, theirs = self.__dict__, other.__dict__
        return all(ours[name] is theirs[name] or ours[name] == theirs[name] for name in type(self).model_fields)

    @model_validator(mode="before")
    @classmethod
    def _lists_are_tuples(cls, table: Any) -> Any:
        return _tuples(dict(table)) if isinstance(table, Mapping) and type(table) is not _Listless else table

    @classmethod
    def stated(cls, **values: Any) -> Self:
        """Settings that the program itself states, as they are: no validator is built for them, which takes longer than
        to import what they are of. `tests/test_settings.py` validates them."""
        return cls.model_construct(**values)  # type: ignore[return-value]


class _Listless(dict[str, Any]):
    """A table in which all lists are tuples, so that tables within it are not looked through once more."""


def _tuples(value: Any) -> Any:
    if isinstance(value, dict):
        return _Listless((key, _tuples(entry)) for key, entry in value.items())
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value


def quantity(default: Any, unit: str, symbol: str, text: str, source: Source, **limits: Any) -> Any:
    """A field with its unit, symbol and source; ``limits`` are pydantic's (gt, ge, lt, le, …)."""
    extra: dict[str, Any] = {"unit": unit, "symbol": symbol, "source": source}
    return Field(default, description=f"{text} [{unit}]", json_schema_extra=extra, **limits)


def schema_of(kind: type[Settings]) -> str:
    """JSON schema of a file of settings; defaults that JSON has no number for (infinity) are left out."""

    def finite(node: Any) -> Any:
        if isinstance(node, dict):
            return {k: finite(v) for k, v in node.items() if not (isinstance(v, float) and math.isinf(v))}
        return [finite(entry) for entry in node] if isinstance(node, list) else node

    return json.dumps(finite(kind.model_json_schema()), indent=2, allow_nan=False)


def one_of(kinds: Iterable[type[Settings]]) -> Any:
    """The type of a table whose ``kind`` says which of these settings it holds (a discriminated union)."""
    return Annotated[Union[tuple(kinds)], Field(discriminator="kind")]  # noqa: UP007  # made from a registry


class SineSum(Settings):
    """What a sum of sines of one amplitude has, whatever it drives."""

    frequencies: tuple[Positive, ...] = Field(description="frequencies [Hz]", min_length=1)
    phases: tuple[float, ...] | None = Field(None, description="phases [rad]; without: Schroeder's, of low peak")

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        if self.phases is not None and len(self.phases) != len(self.frequencies):
            raise ValueError(f"phases has {len(self.phases)} values; it must have {len(self.frequencies)}")
        return self


class Parameters(Settings):
    """Settings whose every value carries a source; a value that differs from the default is ``given``."""

    sources: dict[str, Source] = Field(default_factory=dict, description="where each value comes from")
    deviations: dict[str, Deviation] = Field(
        default_factory=dict,
        description="standard deviations of values that were identified, each in its quantity's unit; "
        "zero for an entry of a list that was not [unit]",
        exclude_if=operator.not_,
    )

    @model_validator(mode="after")
    def _complete_sources(self) -> Self:
        self._complete()
        for name, deviation in self.deviations.items():
            self._check_deviation(name, deviation)
        return self

    def _complete(self) -> None:
        known = self.quantities()
        for name in self.sources:
            if name not in known:
                raise ValueError(f"sources names {name!r}, which is not one of {', '.join(known)}")
        complete: dict[str, Source] = {}
        for name, (_, _, source) in known.items():
            is_default = getattr(self, name) == type(self).model_fields[name].default
            complete[name] = self.sources.get(name, source if is_default else "given")
        object.__setattr__(self, "sources", complete)

    def _check_deviation(self, name: str, deviation: Any) -> None:
        """Refuse the deviation of what has none, or one that is not of its value's shape."""
        if name not in self.sources:
            raise ValueError(f"deviations names {name!r}, which is not one of {', '.join(self.sources)}")
        if self.sources[name] != "identified":
            raise ValueError(
                f"deviations.{name} = {deviation}: the value's source is {self.sources[name]!r}; only one with "
                f"sources.{name} = 'identified' has a deviation"
            )
        value = getattr(self, name)
        if not _alike(deviation, value):
            raise ValueError(f"deviations.{name} = {deviation}: must be as {name} = {value}, a number for each number")

    @classmethod
    def stated(cls, **values: Any) -> Self:
        made = super().stated(**values)
        made._complete()
        return made

    @classmethod
    def quantities(cls) -> dict[str, tuple[str, str, Source]]:
        """Unit, symbol and default source of each physical value, by name."""
        found = {}
        for name, field in cls.model_fields.items():
            extra = field.json_schema_extra
            if isinstance(extra, dict) and "unit" in extra:
                found[name] = (str(extra["unit"]), str(extra["symbol"]), extra["source"])
        return found  # type: ignore[return-value]

    def beyond(self, known: Collection[str]) -> dict[str, Any]:
        """Values that differ from their defaults and are none of ``known``: what a model of those would leave out."""
        fields = type(self).model_fields.items()
        others = {name: field.default for name, field in fields if name not in (*known, *PROVENANCE)}
        return {name: getattr(self, name) for name, default in others.items() if getattr(self, name) != default}

    def with_values(self, values: dict[str, Any]) -> Self:
        """A copy with other values, which become ``given``, without a deviation, unless they are what they were."""
        changed = {
            name: value
            for name, value in values.items()
            if name not in PROVENANCE and getattr(self, name, None) != value
        }
        sources = {name: one for name, one in self.sources.items() if name not in changed} | values.get("sources", {})
        known = {name: one for name, one in self.deviations.items() if sources.get(name) == "identified"}
        own = {"sources": sources, "deviations": known | values.get("deviations", {})}
        return type(self).model_validate({**self.model_dump(exclude=set(PROVENANCE)), **changed, **own})


def _alike(one: Any, other: Any) -> bool:
    """Whether two values are numbers, or lists as long as each other of what is alike."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_alike, one, other))
    return not isinstance(one, tuple | list) and not isinstance(other, tuple | list)
