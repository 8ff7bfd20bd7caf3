"""What every fault has: when it strikes and where, what it makes of the machine, and of what the law reads.

`FaultSettings.after` gives the machine from then on, which is simulated; `settled` the one that it comes to be, of
which the linear model is made; `reading` says what a sensor still tells. The law knows of none of it.
"""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any

from pydantic import Field

from ehamj.arrays import Array
from ehamj.plant.plant import Plant
from ehamj.settings import Positive, Settings


class FaultSettings(Settings):
    """What a user writes in [[fault]] of some ``kind``; ``ehamj.faults.kinds`` lists them."""

    kind: str
    mount: str | None
    time: float = Field(description="when it strikes, at the first step from then on [s]", ge=0)
    settling: Positive = Field(2.0, description="time after it that counts as transient, for what is judged after [s]")

    @property
    @abstractmethod
    def what(self) -> str:
        """What happens, in words that follow the mount's name."""

    @property
    def where(self) -> str:
        """The mount, or what else is struck."""
        return self.mount or "the whole machine"

    @property
    def lasts(self) -> float:
        """Time after it that counts as transient [s]."""
        return self.settling

    def after(self, plant: Plant, spools: Array) -> Plant:
        """The machine from then on; ``spools`` is where the spools stand at that time (mount,) [mA]."""
        return plant

    def settled(self, plant: Plant, spools: Array, elapsed: float) -> Plant:
        """The machine that it has become after a time [s], held still in it; arguments as of `after`."""
        return self.after(plant, spools)

    def strike(self, states: Any) -> None:
        """Change the states of the isolators at once: records of `ehamj.memory.ISOLATOR_STATE` by mount's name."""

    def struck(self, channels: Sequence[str]) -> tuple[str, ...]:
        """Which of these channels it changes the readings of."""
        return ()

    def reading(self, last: float) -> tuple[float, float]:
        """Gain and offset of a struck channel, which read ``last`` before."""
        return 1.0, 0.0

    def named_mounts(self) -> Iterator[tuple[str, str]]:
        """Mounts that it calls by name, each with the key that does."""
        if self.mount is not None:
            yield "mount", self.mount

    def check(self, mounts: Sequence[str]) -> None:
        """Raise ValueError where it names what does not exist beside these mounts."""

    def check_beside(self, other: "FaultSettings") -> None:
        """Raise ValueError where it cannot strike in the same run as another."""


class MountFault(FaultSettings):
    """A fault of the isolator at one mount."""

    mount: str = Field(description="mount whose isolator fails")
