"""Values of the types that a scenario is made of: as one would write them, and as nobody should."""

import math
import string
from collections.abc import Callable
from datetime import date
from random import Random
from typing import Annotated, Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MinLen
from pydantic.fields import FieldInfo
from typing_extensions import is_typeddict

from ehamj.bounds import BOUNDS, NOISE, unit_of
from ehamj.scenario.places import choices, keys_of
from ehamj.settings import FILE, PROVENANCE, Settings

TYPICAL = {
    "Hz": 20.0, "s": 0.02, "m": 0.2, "m/s": 0.1, "m/s²": 5.0, "m/s³": 100.0, "kg": 200.0, "kg m": 1e-4, "kg m²": 300.0,
    "N": 100.0, "rad": 0.5, "deg": 5.0, "V": 0.1, "mA": 0.1, "mA/s": 0.1, "Pa": 1e6, "dB": 6.0, "-": 0.5, "bit": 16.0,
    "m/s or rad/s": 1e-5, "SI of quantity": 1e-5, "(SI of quantity)²/Hz": 1e-12, "m³/s": 1e-4, "m³/s/Pa": 1e-13,
    "m/s/√Hz": 1e-9, "N s/m": 1e3, "N/m": 1e8,
}  # fmt: skip
"""What stands for a number without a default, by its unit."""
SHARE = 0.25
"""Of the keys with a default that are stated all the same."""
DEEP = "@@nested 3000 deep@@"
HUGE = "@@an integer of 400 digits@@"
"""What no writer of TOML writes: put in its place afterwards."""

Hook = Callable[["Drawer", dict[str, Any]], dict[str, Any]]


class Drawer:
    """Draws valid tables: a number near its default, any of the kinds, whatever else the type allows.

    ``hooks`` by class make what must fit together fit; ``names`` by key are what a string may be.
    """

    def __init__(self, random: Random, hooks: dict[str, Hook], share: float = SHARE) -> None:
        self.random, self.hooks, self.share = random, hooks, share
        self.names: dict[str, list[str]] = {}
        self.weights: dict[str, float] = {}
        """How often a kind is drawn beside the others of its union; 1 where nothing stands."""

    def table(self, kind: type[Settings], share: float | None = None) -> dict[str, Any]:
        """A table of settings, with the keys that must be there and some that may."""
        found: dict[str, Any] = {}
        for name, field in kind.model_fields.items():
            key, types = field.alias or name, keys_of(kind)
            if name in PROVENANCE:
                continue
            if name == "kind":
                found["kind"] = get_args(field.annotation)[0]
            elif field.is_required() or self.random.random() < (self.share if share is None else share):
                found[key] = self.value(types[key], key, field)
        hook = self.hooks.get(kind.__name__)
        return hook(self, found) if hook else found

    def value(self, kind: Any, key: str, field: FieldInfo | None) -> Any:
        """A value of a type, which stands under a key."""
        origin, parts = get_origin(kind), get_args(kind)
        if origin is Annotated:
            return self.value(parts[0], key, field)
        if key in self.names and kind is str:
            return self.random.choice(self.names[key])
        default = field.default if field is not None and not field.is_required() else None
        if origin is Literal:
            return self.random.choice(parts)
        several = choices(kind)
        if len(several) > 1 or several[:1] != [kind]:
            weights = [self.weights.get(_kind_of(one), 1.0) for one in several]
            return self.value(self.random.choices(several, weights)[0], key, field)
        if origin is tuple:
            return self._list(parts, key, field, default)
        if origin is dict:
            return {self.word(): self.value(parts[1], key, None) for _ in range(self.random.randrange(3))}
        if isinstance(kind, type) and issubclass(kind, Settings):
            return self.table(kind)
        assert not is_typeddict(kind)
        if kind is bool:
            return self.random.random() < 0.5
        if kind is int:
            return self._within(self.random.randint(1, 6) if default is None else default, field, whole=True)
        if kind is float:
            return self.number(default, field)
        return self.word()

    def number(self, default: Any, field: FieldInfo | None) -> float:
        """A number near its default, or near what is usual of its unit."""
        unit = unit_of(field.description) if field is not None else None
        near = default if isinstance(default, float) and math.isfinite(default) and default else None
        if near is None and default == 0.0 and self.random.random() < 0.5:
            return 0.0
        near = TYPICAL.get(unit or "-", 1.0) if near is None else near
        return float(f"{self._within(near * 2.0 ** self.random.uniform(-1, 1), field):.6g}")

    def _list(self, parts: tuple[Any, ...], key: str, field: FieldInfo | None, default: Any) -> list[Any]:
        if parts[1:] == (...,):
            least = next((one.min_length for one in (field.metadata if field else ()) if isinstance(one, MinLen)), 0)
            return [
                self.value(parts[0], key, self._entry(field, None))
                for _ in range(self.random.randint(least, least + 2))
            ]
        defaults = default if isinstance(default, tuple) and len(default) == len(parts) else [None] * len(parts)
        return [self.value(part, key, self._entry(field, one)) for part, one in zip(parts, defaults, strict=True)]

    @staticmethod
    def _entry(field: FieldInfo | None, default: Any) -> FieldInfo | None:
        if field is None:
            return None
        entry = FieldInfo(annotation=None, description=field.description)
        if default is not None:
            entry.default = default
        return entry

    @staticmethod
    def _within(value: Any, field: FieldInfo | None, whole: bool = False) -> Any:
        for limit in field.metadata if field is not None else ():
            if isinstance(limit, Le):
                value = min(value, limit.le)
            elif isinstance(limit, Lt):
                value = min(value, limit.lt - 1 if whole else limit.lt * (0.9 if float(limit.lt) > 0 else 1.1))
            elif isinstance(limit, Ge):
                value = max(value, limit.ge)
            elif isinstance(limit, Gt):
                value = max(value, limit.gt + 1 if whole else limit.gt + 1e-9)
        return value

    def word(self) -> str:
        """A short name."""
        return "".join(self.random.choices(string.ascii_lowercase, k=5))


def _kind_of(kind: Any) -> str:
    return kind.__name__ if isinstance(kind, type) else ""


def edges(unit: str | None) -> list[float]:
    """Numbers at and beyond the bounds of a unit."""
    least, largest = BOUNDS.get(unit or "-", NOISE)
    near = [least, largest, 0.999 * largest, 1.001 * largest, 0.999 * least, 1.001 * least, math.sqrt(largest)]
    return [float(f"{sign * one:.9g}") for one in near for sign in (1.0, 1.0, -1.0)]


def wild(random: Random, value: Any, unit: str | None = None) -> Any:
    """What stands in the place of a value and should not, or hardly should."""
    plain: list[Any] = [
        "text", "", "a" * 20_000, "Ünïcode → 振動\u200b\u202e", "example:../../../etc/passwd", "0", "nan",

        True, False, math.nan, math.inf, -math.inf, 1e300, -1e300, 1e-300, 5e-324, 0, 0.0, -0.0, -1, -1.0, 1, 1.5,
        2**31, 2**63 - 1, -(2**63), 2**63, HUGE, [], [[]], {}, {"": 1}, {"kind": "sine"}, {"kind": 3},
        [[1.0], [2.0, 3.0]], "a\nb\tc\x01",
        [1.0] * 5000, ["a", 1.0, True], DEEP, date(2026, 1, 5), [math.nan] * 3, [0.0] * 3, [0.0] * 2, "*", "[red]",
        "{0}", "%s",
    ]  # fmt: skip
    if isinstance(value, bool):
        return random.choice(plain)
    if isinstance(value, int | float) and random.random() < 0.6:
        near = [
            -value,
            value * 10,
            value / 10,
            value * 1e3,
            value / 1e3,
            value * 1e6,
            value / 1e6,
            value + 1,
            value - 1,
            str(value),
        ]
        return random.choice([*near, *edges(unit)])
    if isinstance(value, list) and random.random() < 0.6:
        return _other_list(random, value, unit)
    if isinstance(value, str) and value and random.random() < 0.5:
        near = [
            value.upper(),
            value[:-1],
            value + " ",
            value * 2,
            value.replace(value[0], "ß", 1),
            "/" + value,
            value + "\0",
        ]
        return random.choice(near)
    return random.choice(plain)


def _other_list(random: Random, value: list[Any], unit: str | None) -> list[Any]:
    found = list(value)
    at = random.randrange(len(found)) if found else 0
    how = random.randrange(6)
    if how == 0:
        return found[:-1]
    if how == 1:
        return [*found, *(found[-1:] or [1.0])]
    if how == 2:
        return found[::-1]
    if how == 3:
        return [found]
    if how == 4:
        return found * 2
    if found:
        found[at] = wild(random, found[at], unit)
    return found


def is_file(kind: Any) -> bool:
    """Whether a type is that of a file's name."""
    return get_origin(kind) is Annotated and FILE in kind.__metadata__
