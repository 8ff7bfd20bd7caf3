"""What the values of a parameter may be: a range, a list, a distribution, or a tolerance about the scenario's own.

Which of them a table is follows from its keys, as one would say it: ``{ low = 3000.0, high = 5000.0 }``,
``{ values = ["VC-C", "VC-D"] }``, ``{ mean = 4000.0, deviation = 50.0 }``, ``{ tolerance = 0.05 }``,
``{ off = 0.02 }``, ``{ factor = 2.0 }``, ``{ low = 3000.0, mode = 4000.0, high = 4500.0 }``.
"""

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self, Union

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from ehamj.arrays import Array
from ehamj.campaign.spread import SIGMAS, SpreadSettings, check_number, check_rising, is_whole, normal_within

Shape = Literal["even", "normal"]


class Listed(SpreadSettings):
    """A value of a list, each as often as any other."""

    values: tuple[Any, ...] = Field(description="values: numbers, strings, or whatever the key may be", min_length=2)

    @model_validator(mode="after")
    def _differ(self) -> Self:
        for k, one in enumerate(self.values):
            if isinstance(one, float) and not np.isfinite(one):
                raise ValueError(f"values has {one}; must be finite")
            if any(one == other and type(one) is type(other) for other in self.values[:k]):
                raise ValueError(f"values has {one!r} twice")
        return self

    def quantiles(self, points: Array, own: Any) -> Array:
        """Numbers of the entries, which are no values themselves."""
        return np.minimum(np.floor(points * len(self.values)), len(self.values) - 1.0)

    def cells(self, own: Any) -> int:
        return len(self.values)

    @property
    def numbers(self) -> bool:
        """Whether all values are numbers."""
        return all(isinstance(one, int | float) and not isinstance(one, bool) for one in self.values)

    @property
    def ordered(self) -> bool:
        """Whether they are numbers that rise."""
        pairs = zip(self.values, self.values[1:], strict=False)
        return self.numbers and all(one < other for one, other in pairs)


class Between(SpreadSettings):
    """Anything between two values, evenly."""

    low: float = Field(description="least value, in the key's unit [unit]")
    high: float = Field(description="largest value, in the key's unit [unit]")
    scale: Literal["linear", "log"] = Field("linear", description="whether values or their logarithms are even")

    @model_validator(mode="before")
    @classmethod
    def _any_of_it(cls, table: Any) -> Any:
        if isinstance(table, Mapping) and not {"low", "high"} & table.keys():
            raise ValueError(f"must have {FORMS}")
        return table

    @model_validator(mode="after")
    def _rising(self) -> Self:
        check_rising(self.low, self.high)
        if self.scale == "log" and self.low <= 0.0:
            raise ValueError(f"low = {self.low:g}: must be above 0 for scale = 'log'")
        return self

    def quantiles(self, points: Array, own: Any) -> Array:
        if self.scale == "log":
            values = self.low * np.exp(points * np.log(self.high / self.low))
        else:
            values = self.low + points * (self.high - self.low)
        return np.clip(np.where(points == 1.0, self.high, values), self.low, self.high)

    def whole(self, points: Array, own: Any) -> Array:
        count = self.cells(own)
        if count is None:
            return super().whole(points, own)
        return self.low + np.minimum(np.floor(points * count), count - 1.0)

    def cells(self, own: Any) -> int | None:
        """Of an integer."""
        return int(self.high - self.low) + 1 if is_whole(own) and self.scale == "linear" else None

    def check(self, own: Any) -> None:
        if is_whole(own) and not (self.low.is_integer() and self.high.is_integer()):
            raise ValueError(f"low = {self.low:g}, high = {self.high:g}: must be integers, as the scenario's {own} is")


class Normal(SpreadSettings):
    """Normally distributed, within limits where there are any."""

    mean: float | None = Field(None, description="mean, in the key's unit; the scenario's own value without [unit]")
    deviation: float = Field(gt=0, description="standard deviation (before it is limited), in the key's unit [unit]")
    low: float | None = Field(None, description="least value, in the key's unit [unit]")
    high: float | None = Field(None, description="largest value, in the key's unit [unit]")

    @model_validator(mode="after")
    def _holds_anything(self) -> Self:
        low, high = self._limits
        check_rising(low, high)
        if self.mean is not None:
            self._check_far(self.mean)
        return self

    @property
    def _limits(self) -> tuple[float, float]:
        return (-np.inf if self.low is None else self.low), (np.inf if self.high is None else self.high)

    def _check_far(self, mean: float) -> None:
        far = max((self._limits[0] - mean) / self.deviation, (mean - self._limits[1]) / self.deviation)
        if far > 2 * SIGMAS:
            raise ValueError(
                f"low to high is {far:.3g} deviations off the mean = {mean:g}: must be at most {2 * SIGMAS:g}"
            )

    def quantiles(self, points: Array, own: Any) -> Array:
        mean, (low, high) = own if self.mean is None else self.mean, self._limits
        return normal_within(points, mean, self.deviation, low, high)

    def edges(self) -> tuple[float, float]:
        """Three deviations from the mean where nothing limits it."""
        from scipy.special import ndtr

        tail = float(ndtr(-SIGMAS))
        return (tail if self.low is None else 0.0), (1.0 - tail if self.high is None else 1.0)

    def check(self, own: Any) -> None:
        if self.mean is None:
            check_number(own, "mean")
            self._check_far(own)


class _About(SpreadSettings):
    """To both sides of the scenario's own value."""

    shape: Shape = Field("even", description="even, or normal with the limits at three standard deviations")

    @abstractmethod
    def reach(self, own: float) -> float:
        """To one side, in the key's unit."""

    def quantiles(self, points: Array, own: Any) -> Array:
        reach = self.reach(own)
        if self.shape == "normal":
            return normal_within(points, own, reach / SIGMAS, own - reach, own + reach)
        return np.clip(own + (2.0 * points - 1.0) * reach, own - reach, own + reach)

    def check(self, own: Any) -> None:
        check_number(own, "low and high")


class Tolerance(_About):
    """Off the scenario's own value by at most a share of it, to both sides."""

    tolerance: float = Field(gt=0, lt=1, description="largest share of the scenario's own value that it is off [-]")

    def reach(self, own: float) -> float:
        return self.tolerance * abs(own)

    def check(self, own: Any) -> None:
        super().check(own)
        if own == 0:
            raise ValueError(
                "tolerance is a share of the scenario's own value, which is 0: state off, in the key's unit"
            )


class Off(_About):
    """Off the scenario's own value by at most so much, to both sides."""

    off: float = Field(gt=0, description="by how much it is off at most, in the key's unit [unit]")

    def reach(self, own: float) -> float:
        return self.off


class Factor(SpreadSettings):
    """Between the scenario's own value over a factor and so many times it, evenly in its logarithm."""

    factor: float = Field(gt=1, description="largest factor to both sides of the scenario's own value [-]")

    def quantiles(self, points: Array, own: Any) -> Array:
        ends = sorted((own / self.factor, own * self.factor))
        return np.clip(own * self.factor ** ((2.0 * points - 1.0) * np.sign(own)), *ends)

    def check(self, own: Any) -> None:
        check_number(own, "low and high")
        if own == 0:
            raise ValueError("factor is of the scenario's own value, and that is 0: state off instead")


class Triangular(SpreadSettings):
    """Most likely at one value, and less and less so towards two others."""

    low: float = Field(description="least value, in the key's unit [unit]")
    mode: float = Field(description="likeliest value, in the key's unit [unit]")
    high: float = Field(description="largest value, in the key's unit [unit]")

    @model_validator(mode="after")
    def _rising(self) -> Self:
        check_rising(self.low, self.high)
        if not self.low <= self.mode <= self.high:
            raise ValueError(f"mode = {self.mode:g}: must be from low = {self.low:g} to high = {self.high:g}")
        return self

    def quantiles(self, points: Array, own: Any) -> Array:
        wide, left, right = self.high - self.low, self.mode - self.low, self.high - self.mode
        rising, falling = self.low + np.sqrt(points * wide * left), self.high - np.sqrt((1.0 - points) * wide * right)
        return np.clip(np.where(points * wide < left, rising, falling), self.low, self.high)


SPREADS: Final[dict[str, type[SpreadSettings]]] = {
    "values": Listed,
    "tolerance": Tolerance,
    "off": Off,
    "factor": Factor,
    "mode": Triangular,
    "deviation": Normal,
    "mean": Normal,
}
"""Which spread a table is, by the first of these keys that it has; `Between` with none of them."""

FORMS: Final = (
    "low and high, or values, or mean and deviation, or low, mode and high, or one of the scenario's own value: "
    "tolerance (a share of it), off (in the key's unit), factor"
)


def _form(table: Any) -> str:
    """Name of the kind that a table or a spread is; tables that are none are refused by `Between`."""
    if isinstance(table, SpreadSettings):
        return type(table).__name__
    keys = table if isinstance(table, Mapping) else ()
    return next((SPREADS[key].__name__ for key in SPREADS if key in keys), Between.__name__)


if TYPE_CHECKING:
    Spread = SpreadSettings
else:
    _KINDS = (Between, *dict.fromkeys(SPREADS.values()))
    Spread = Annotated[
        Union[tuple(Annotated[kind, Tag(kind.__name__)] for kind in _KINDS)],  # noqa: UP007  # made from a table
        Discriminator(_form),
    ]


def by_dotted_key(table: Any) -> Any:
    """Tables within tables as one of dotted keys: TOML reads ``machine.mass = { … }`` as a table in a table, and
    ``"machine.mass" = { … }`` as what is meant."""
    if not isinstance(table, Mapping):
        return table
    found: dict[str, Any] = {}
    for key, entry in table.items():
        if isinstance(entry, Mapping) and entry and all(isinstance(inner, Mapping) for inner in entry.values()):
            found |= {f"{key}.{inner}": spread for inner, spread in by_dotted_key(entry).items()}
        else:
            found[str(key)] = entry
    return found


Vary = Annotated[dict[str, Spread], BeforeValidator(by_dotted_key)]
"""The spreads of a study by dotted key of its scenario."""
