"""What every test has: a name, how the machine was, and what makes residuals of it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import Field

from ehamj.errors import InputError
from ehamj.identification.residual import Residuals
from ehamj.measured.settings import Measurement
from ehamj.scenario.load import otherwise
from ehamj.scenario.model import Engine, Scenario
from ehamj.settings import OVERRIDES, Settings


@dataclass(frozen=True)
class Context:
    """What a test's residuals are made with."""

    scenario: Scenario
    """The machine as the file has it, before what the test has otherwise."""
    keys: tuple[str, ...]
    """Parameters that are looked for."""
    engine: Engine = "small-motion"
    threads: int | None = None
    tests: tuple[str, ...] = ()
    """Names of all tests, in the file's order."""
    measured: Mapping[str, Any] = field(default_factory=dict)
    """Measurements that were given in memory, by the test's name, in place of its file."""


class TestSettings(Settings, ABC):
    """Base of all kinds of test."""

    __test__ = False  # no test of pytest's

    name: str = Field(description="what it is called", min_length=1)
    set: Annotated[dict[str, Any], OVERRIDES] = Field(
        default_factory=dict, description="how the machine was in this test, where that is otherwise"
    )
    hold_out: bool = Field(False, description="not fitted, only compared with in the end (validation)")

    @abstractmethod
    def residuals(self, context: Context) -> Residuals:
        """What compares it with the model.

        Raises:
            InputError: if its file cannot be read, or does not suit the scenario; the message names the test.
        """

    def place(self, context: Context) -> str:
        """Key of its table, as messages name it."""
        return f"test.{context.tests.index(self.name)}" if self.name in context.tests else f"test {self.name!r}"

    def scenario(self, context: Context) -> Scenario:
        """The machine as it was in this test."""
        return otherwise(context.scenario, self.set, f"{self.place(context)}.set")


def check_channels(measurement: Measurement, key: str) -> None:
    """Refuse accelerometers at points, which these kinds of test do not compare.

    Raises:
        InputError: naming which.
    """
    for component, said in measurement.items():
        if said.accelerometer is not None:
            raise InputError(
                f"{key}.measurement.{component}.accelerometer: is of kind = 'hammer' only; measure a foot's or the "
                "machine's channel here, or leave it out"
            )
