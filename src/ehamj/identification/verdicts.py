"""What came of a choice: every fit that was tried, and a sentence for each option."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ehamj.identification.evidence import Effect
from ehamj.identification.optional import Criterion, Place

NAMES: Mapping[str, str] = {"bic": "BIC", "aicc": "AICc"}


@dataclass(frozen=True)
class Tried:
    """A model with one option more than another, and what that one gains."""

    without: tuple[str, ...]
    """Options of the smaller model."""
    option: str
    gain: float
    """Fall of −2·log likelihood."""
    bic: float
    """Fall of BIC; negative: it rises."""
    aicc: float
    """The same of AICc."""
    fitted: bool
    """Or estimated to first order, where that was too little to be worth a fit."""


@dataclass(frozen=True)
class Verdict:
    """Of one option."""

    option: str
    justified: bool
    told: bool
    """Whether the data can tell: where False, one that matters would not show."""
    values: Mapping[str, tuple[float, float]]
    """Value and standard deviation by key, of one that is justified."""
    most: float
    """Of one that is not: largest size that goes with the data (two deviations), as share of the stroke or of 1."""
    words: str


@dataclass(frozen=True)
class Choice:
    """Which options of the valve the data justify."""

    criterion: Criterion
    justified: tuple[str, ...]
    """In the order in which they were found."""
    verdicts: Mapping[str, Verdict]
    """By option, in the file's order."""
    tried: tuple[Tried, ...]

    def to_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        return {
            "criterion": self.criterion,
            "justified": list(self.justified),
            "options": {
                name: {
                    "justified": one.justified, "told": one.told, "words": one.words, "most": one.most,
                    "values": {key: list(pair) for key, pair in one.values.items()},
                }
                for name, one in self.verdicts.items()
            },
            "tried": [
                {
                    "without": list(one.without), "option": one.option, "gain": one.gain, "bic_falls_by": one.bic,
                    "aicc_falls_by": one.aicc, "fitted": one.fitted,
                }
                for one in self.tried
            ],
        }  # fmt: skip

    def __str__(self) -> str:
        """A sentence for each option."""
        return "\n".join(one.words for one in self.verdicts.values())


def justified(
    places: tuple[Place, ...], values: Mapping[str, tuple[float, float]], tried: Tried, criterion: Criterion
) -> Verdict:
    """An option that the data justify."""
    parts = [f"{place.key} = {_spread(place, *values[place.key])}" for place in places]
    option = places[0].option
    words = f"the data justify {option.about}: {', '.join(parts)}; {_criteria(tried, criterion)}"
    return Verdict(places[0].name, True, True, values, 0.0, words)


def needless(places: tuple[Place, ...], effect: Effect, tried: Tried, criterion: Criterion) -> Verdict:
    """An option that they do not: it is not there, or would not show."""
    option = places[0].option
    most = abs(effect.best) + 2.0 * effect.deviation
    limit = _size(places[0], most)
    if not most <= option.matters:
        words = f"these tests cannot tell {option.about}: one of {limit} would not show; it shows in {option.seen_by}"
        return Verdict(places[0].name, False, False, {}, most, words)
    words = f"{option.about} is not needed: no more than {limit} goes with the data; {_criteria(tried, criterion)}"
    return Verdict(places[0].name, False, True, {}, most, words)


def _spread(place: Place, value: float, deviation: float) -> str:
    unit = "" if place.unit == "1" else f" {place.unit}"
    share = f" ({100.0 * place.size(value):.2g} % of the stroke)" if place.option.of_stroke else ""
    return f"{value:.4g} ± {deviation:.2g}{unit}{share}"


def _size(place: Place, size: float) -> str:
    """A size in the unit of the value, and as a share."""
    scaled = size * place.option.scale(place.actuator)
    if place.option.of_stroke:
        return f"{scaled:.2g} {place.unit} ({100.0 * size:.2g} % of the stroke)"
    return f"{scaled:.2g}"


def _criteria(tried: Tried, criterion: Criterion) -> str:
    """What both criteria say, the one that decided first."""
    order = [criterion, "aicc" if criterion == "bic" else "bic"]
    parts = []
    for name in order:
        fall = tried.bic if name == "bic" else tried.aicc
        verb = ("falls" if fall > 0 else "rises") if tried.fitted else ("would fall" if fall > 0 else "would rise")
        parts.append(f"{NAMES[name]} {verb} by {abs(fall):.3g}")
    return " and ".join(parts)
