"""What comes back of an identification: values with deviations, what the data cannot tell, and how well it fits."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.residual import Axis
from ehamj.identification.whiteness import Whiteness
from ehamj.scenario.model import Scenario

if TYPE_CHECKING:
    from ehamj.identification.file import IdentifyFile

Status = Literal["identified", "unidentifiable", "prior"]
"""Told by the data; not told by them; told by what was known before alone."""


@dataclass(frozen=True)
class Identified:
    """One value that was looked for."""

    value: float | None
    """None where the data cannot tell it."""
    deviation: float | None
    """Standard deviation, in ``unit``."""
    unit: str
    start: float
    """The scenario's own value, at which the fit began."""
    bounds: tuple[float, float]
    at_bound: Literal["", "low", "high"]
    """The bound at which it stands, if it does: its deviation then says little."""
    status: Status
    why: str = ""
    """In words, where there is something to say."""


@dataclass(frozen=True)
class Combination:
    """A direction in the parameters that the data cannot tell."""

    parameters: tuple[str, ...]
    """Keys that take part, by their share."""
    vector: Array
    """Direction over all parameters in the order of `Identification.values`, scaled as they are looked for, (k,)."""
    words: str


@dataclass(frozen=True)
class ChannelFit:
    """One channel of a test, measured beside model."""

    name: str
    unit: str
    axis: Axis
    at: Array
    """Times [s], frequencies [Hz] or numbers, (n,)."""
    measured: Array | ComplexArray
    predicted: Array | ComplexArray
    deviation: Array
    """Standard deviation of each sample's error, as stated or estimated, (n,)."""
    fit: float
    """100·(1 − |measured − predicted|/|measured − its mean|) [%]."""
    whiteness: Whiteness | None
    """None where samples are not in an order, or too few."""
    coherence: Array | None = None


@dataclass(frozen=True)
class TestFit:
    """One test, fitted or held out."""

    __test__ = False  # no test of pytest's

    name: str
    kind: str
    channels: tuple[ChannelFit, ...]
    unknowns: Mapping[str, Identified]
    """Its own unknowns: offsets, gains, delays."""
    found: Mapping[str, Any] = field(default_factory=dict)
    """What else the test says (paired modes), by what it is called."""


@dataclass(frozen=True)
class Identification:
    """What was found."""

    file: "IdentifyFile"
    scenario: Scenario
    """The identified machine: each value that was told carries source and deviation; others are as they were."""
    values: Mapping[str, Identified]
    """By the scenario's key, in the file's order."""
    correlation: Array
    """Between the values, (k, k); NaN where one is not told."""
    combinations: tuple[Combination, ...]
    tests: tuple[TestFit, ...]
    validation: tuple[TestFit, ...]
    """Tests that were held out."""
    cost: float
    """−2·log likelihood of the data at the end (priors not counted)."""
    samples: int
    """Of all fitted channels; a complex one counts twice."""
    notes: tuple[str, ...] = ()
    """Warnings a reader must know."""
    told: Mapping[str, Any] = field(default_factory=dict)
    """How the fit went: ``starts``, ``iterations``, ``runs``, ``seconds``, ``converged`` with its reason."""
    profiles: Mapping[str, Array] = field(default_factory=dict)
    """Profile likelihoods by key: values and rise of −2·log likelihood, (n, 2)."""
    choice: Any = None
    """Which options of the valve the data justify (`ehamj.identification.choice`), where that was asked."""

    def to_dict(self) -> dict[str, Any]:
        """Its numbers, as JSON has them; samples are left out."""
        from ehamj.identification.saving import to_dict

        return to_dict(self)

    def save(self, folder: str | Path) -> None:
        """Write scenario, numbers and page into a folder that is there.

        Raises:
            OSError: if a file cannot be written.
        """
        from ehamj.identification.saving import save

        save(self, Path(folder))

    def __str__(self) -> str:
        """Values with their deviations, a line each."""
        return "\n".join(line_of(key, one) for key, one in self.values.items())


def line_of(key: str, one: Identified) -> str:
    """A value in words."""
    if one.value is None:
        return f"{key}: not told by the data{f' ({one.why})' if one.why else ''}"
    spread = "" if one.deviation is None else f" ± {one.deviation:.2g}"
    return f"{key}: {one.value:.5g}{spread} {one.unit}".rstrip() + (f" ({one.why})" if one.why else "")
