"""An identification file: which machine, which of its values are looked for, and which tests tell them."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from ehamj.identification.optional import ChoiceSettings, with_neutral
from ehamj.identification.planning.settings import PlanSettings
from ehamj.identification.tests.kinds import TESTS
from ehamj.scenario.load import as_scenario, otherwise, settings_of
from ehamj.scenario.model import Engine, Scenario
from ehamj.scenario_files import shipped_identifications
from ehamj.settings import OVERRIDES, SCENARIO, Positive, Settings, one_of

Overrides = Annotated[dict[str, Any], OVERRIDES]


class PriorSettings(Settings):
    """What is known of a value before the tests."""

    mean: float = Field(description="most likely value, in the unit of the key [unit]")
    deviation: Positive = Field(description="standard deviation [unit]")


class ParameterSettings(Settings):
    """How one value is looked for."""

    bounds: tuple[float, float] | None = Field(
        None, description="least and largest value; without: half to twice the scenario's own [unit]"
    )
    prior: PriorSettings | None = Field(None, description="what is known of it before")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.bounds is not None and not self.bounds[0] < self.bounds[1]:
            raise ValueError(f"bounds = {list(self.bounds)}: the first must be below the second")
        return self


class FitSettings(Settings):
    """How the values are looked for."""

    starts: int = Field(4, ge=1, le=1000, description="points within the bounds at which the fit begins")
    seed: int = Field(0, ge=0, description="of these points")
    iterations: int = Field(30, ge=1, le=1000, description="steps of one fit at most")
    profile: tuple[str, ...] = Field((), description="parameters whose profile likelihood is wanted")
    doubtful: Literal["refuse", "note"] = Field(
        "refuse",
        description="what becomes of channels that look reversed, of another unit or of another clock beside the "
        "model: "
        "refuse all, or fit them and note it",
    )


class IdentifyFile(Settings):
    """Parameters of a machine from measurements."""

    title: str = Field("Identification", description="what its page is called", min_length=1)
    scenario: Annotated[str, SCENARIO] = Field("recorded", description="a shipped scenario's name, or a scenario file")
    set: Overrides = Field(default_factory=dict, description="what of the scenario is otherwise, in tables as there")
    engine: Engine = Field("small-motion", description="what steps the machine for tests that are compared in time")
    parameters: dict[str, ParameterSettings] = Field(
        description="values that are looked for, by the scenario's keys", min_length=1
    )
    test: tuple[one_of(TESTS), ...] = Field((), description="tests that were made")  # type: ignore[valid-type]
    fit: FitSettings = Field(
        FitSettings.stated(starts=4, seed=0, iterations=30, profile=(), doubtful="refuse"), description="how"
    )
    choice: ChoiceSettings | None = Field(None, description="options of the valves that the tests may justify")
    plan: PlanSettings | None = Field(None, description="tests that could be made next; without: sensible ones")

    @field_validator("parameters", mode="before")
    @classmethod
    def _in_quotes(cls, given: Any) -> Any:
        """In TOML a key with dots that stand in no quotes is a table in a table."""
        for key, value in given.items() if isinstance(given, Mapping) else ():
            whole = _whole(key, value)
            if whole != key:
                raise ValueError(f'a key with dots stands in quotes: "{whole}" = …')
        return given

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        names = [one.name for one in self.test]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"test: two are called {twice!r}; each needs a name of its own")
        if self.test and all(one.hold_out for one in self.test):
            raise ValueError("test: all are held out (hold_out = true); at least one must be fitted")
        for key in self.fit.profile:
            if key not in self.parameters:
                raise ValueError(f"fit.profile: {key!r} must be one of {', '.join(self.parameters)}")
        return self

    @property
    def machine(self) -> Scenario:
        """What the tests were made on, as far as it is known, with what the options of its valves need.

        Raises:
            InputError: if there is no such scenario, or what is set is not allowed.
        """
        machine = otherwise(as_scenario(self.scenario), self.set, "set")
        return machine if self.choice is None else with_neutral(self.choice, machine)


def _whole(key: str, value: Any) -> str:
    """A key with those of the tables in it, down to what is said of a parameter."""
    below = set(value) - set(ParameterSettings.model_fields) if isinstance(value, Mapping) else set[str]()
    tables = sorted(one for one in below if isinstance(value[one], Mapping))
    return _whole(f"{key}.{tables[0]}", value[tables[0]]) if tables else key


def load_identify(source: str | Path | Mapping[str, Any] | IdentifyFile, overrides: Iterable[str] = ()) -> IdentifyFile:
    """Read an identification file.

    Args:
        source: a shipped name, a TOML file, or its content.
        overrides: ``a.b=value`` each, applied to its content, as ``ehamj identify FILE --set`` has them.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    return settings_of(IdentifyFile, source, overrides, shipped_identifications(), "identification")
