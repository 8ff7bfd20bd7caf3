"""A study file: which machine, what is varied, which designs that makes, and what is asked of them.

A study goes through stages, in this order; its designs have numbers through all of them:

- ``named``: the scenario's own design ("as it is", number 0) and each of ``named``, with values of their own keys;
- ``search``: the designs of the plan, within ``vary``;
- ``tolerance``: machines within ``tolerances`` around each of the ``best`` of search (by `Goals`) and of the named
  ones, whose ``parent`` is that design;
- ``confirm``: these designs once more, on the machine as ``confirm.set`` has it; ``parent`` is the design.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ehamj.campaign.correlations import Correlation
from ehamj.campaign.parameters import Space
from ehamj.campaign.plans.kinds import PLANS, MonteCarlo
from ehamj.campaign.plans.plan import Goals
from ehamj.campaign.spreads import Vary
from ehamj.merits import catalogue  # noqa: F401  # fills the sources of merits
from ehamj.merits.merit import Machine, source_of
from ehamj.scenario.keys import entries
from ehamj.scenario.load import as_scenario, otherwise, settings_of
from ehamj.scenario.variation import LawChoice
from ehamj.scenario_files import shipped_studies
from ehamj.settings import OVERRIDES, SCENARIO, Settings, one_of

Overrides = Annotated[dict[str, Any], OVERRIDES]


class Limit(Settings):
    """What a merit must keep."""

    at_least: float | None = Field(None, description="least that is allowed, in the merit's unit [unit]")
    at_most: float | None = Field(None, description="most that is allowed, in the merit's unit [unit]")

    @model_validator(mode="after")
    def _allows(self) -> Self:
        low, high = self.at_least, self.at_most
        if low is None and high is None:
            raise ValueError("must have at_least, at_most, or both")
        if low is not None and high is not None and low > high:
            raise ValueError(f"at_least = {low:g} must not be above at_most = {high:g}")
        return self

    def met(self, value: float) -> bool:
        """Whether a value keeps it; NaN does not."""
        low, high = self.at_least, self.at_most
        return bool((low is None or value >= low) and (high is None or value <= high) and value == value)


class Tolerances(Settings):
    """Machines within tolerances around the best designs: what they come out with, and how many keep the limits."""

    vary: Vary = Field(description="what is not quite as designed, by key", min_length=1)
    correlation: tuple[Correlation, ...] = Field((), description="values that go together")
    number: int = Field(200, ge=1, le=1_000_000, description="machines of each design")
    seed: int = Field(0, ge=0, description="of the draws")
    merits: tuple[str, ...] | None = Field(None, description="which merits; those of the limits and objectives without")

    @property
    def plan(self) -> MonteCarlo:
        """The draws."""
        return MonteCarlo(kind="monte-carlo", number=self.number, seed=self.seed)


class Confirm(Settings):
    """The best designs once more, otherwise: on another engine, for longer, on another floor."""

    set: Overrides = Field(default_factory=dict, description="what of the scenario is otherwise")
    merits: tuple[str, ...] | None = Field(None, description="which merits; those of the limits and objectives without")


class Budget(Settings):
    """How much a study may take."""

    designs: int = Field(100_000, ge=1, description="designs, of all stages together")
    hours: float | None = Field(None, gt=0, description="beyond which no further block begins [h]")


class StudyFile(Settings):
    """A study of many designs of one machine."""

    title: str = Field(description="what its page is called")
    question: str = Field(description="what it answers, one line")
    scenario: Annotated[str, SCENARIO] = Field("recorded", description="a shipped scenario's name, or a scenario file")
    set: Overrides = Field(default_factory=dict, description="what of the scenario is otherwise, in tables as there")
    law: LawChoice = Field(
        "held", description="a digital law held as derived for the scenario, or derived for each design"
    )
    vary: Vary = Field(description="parameters by the scenario's keys, and how their values spread", min_length=1)
    correlation: tuple[Correlation, ...] = Field((), description="parameters that go together")
    plan: one_of(PLANS) = Field(description="which designs")  # type: ignore[valid-type]
    named: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="designs with a name to compare with: values by the scenario's keys"
    )
    merits: tuple[str, ...] = Field((), description="figures of merit, beside those of objectives and limits")
    objectives: dict[str, Literal["highest", "lowest"]] = Field(
        default_factory=dict, description="merits by which designs are better: highest or lowest"
    )
    limits: dict[str, Limit] = Field(default_factory=dict, description="what merits must keep, for a design to be good")
    best: int = Field(3, ge=0, le=100, description="how many of the best designs are kept as scenarios")
    tolerances: Tolerances | None = Field(
        None, description="machines within tolerances around the best and named designs"
    )
    confirm: Confirm | None = Field(None, description="the best and named designs once more, otherwise")
    budget: Budget = Field(Budget.stated(designs=100_000, hours=None), description="how much it may take")

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        more = [stage.merits or () for stage in (self.tolerances, self.confirm) if stage is not None]
        for name in (*self.wanted, *(name for names in more for name in names)):
            source_of(name)
        return self

    @property
    def wanted(self) -> tuple[str, ...]:
        """Names of all merits, those of objectives and limits first."""
        return tuple(dict.fromkeys((*self.objectives, *self.limits, *self.merits)))

    @property
    def goals(self) -> Goals:
        """What a search looks for."""
        signs = {"lowest": 1.0, "highest": -1.0}
        return Goals(
            [(name, signs[best]) for name, best in self.objectives.items()],
            [(name, limit.at_least, limit.at_most) for name, limit in self.limits.items()],
        )

    @property
    def values_of_named(self) -> dict[str, dict[str, Any]]:
        """Values of each named design by dotted key, however its table is nested."""
        return {name: {".".join(key): value for key, value in entries(table)} for name, table in self.named.items()}

    @property
    def machine(self) -> Machine:
        """What designs differ from.

        Raises:
            InputError: if there is no such scenario, or what is set is not allowed.
        """
        return Machine(otherwise(as_scenario(self.scenario), self.set, "set"), self.law)

    def space(self, machine: Machine) -> Space:
        """The parameters together.

        Raises:
            InputError: if a key is none of the scenario's, or a spread leaves it no values.
        """
        return Space.of(machine.scenario, self.vary, self.correlation)


def load_study(source: str | Path | Mapping[str, Any] | StudyFile, overrides: Iterable[str] = ()) -> StudyFile:
    """Read a study.

    Args:
        source: a TOML file, the name of a shipped study, or its content.
        overrides: ``a.b=value`` each, applied to its content, as ``ehamj study FILE --set`` has them.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    return settings_of(StudyFile, source, overrides, shipped_studies(), "study")
