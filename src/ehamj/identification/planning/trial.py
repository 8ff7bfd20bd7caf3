"""A test that could be made: a scenario that would be run, what is played in it, and how its end is."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ehamj.arrays import Array
from ehamj.rig.low_peak import LowPeak
from ehamj.scenario.model import Scenario

Course = Literal["periodic", "decaying", "random", "nonlinear", "rest"]
"""How a test's signals are: they repeat; die out; go on at random; only the nonlinear engine has them; or it is at rest
under held loads, and readings are averaged."""


@dataclass(frozen=True)
class Trial:
    """One test."""

    name: str
    kind: str
    words: str
    """What is done, one line."""
    scenario: Scenario
    """As it is run; of a test at rest, the machine as it stands."""
    course: Course
    settle: float = 0.0
    """Time at the beginning that is not compared [s]."""
    played: Mapping[str, LowPeak] = field(default_factory=dict)
    """Multisines by what they drive: a channel ``valve_command MOUNT`` [V], or ``force`` [N]."""
    loads: tuple[tuple[float, ...], ...] = ()
    """Held forces and moments at the centre of gravity of a test at rest, 6 each [N, N m]."""
    load_words: tuple[Mapping[str, object], ...] = ()
    """The same as the user has them: force [N], point [m], direction."""
    seconds: float = 0.0
    """What it takes at the rig [s]."""
    inputs: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    """What is recorded of what drives the machine, as entries of [test.measurement]."""
    otherwise: Mapping[str, object] = field(default_factory=dict)
    """How the machine is in this test, as ``set`` of [[test]] has it."""

    @property
    def compared(self) -> float:
        """Time that is compared [s]; of a test at rest, that each reading is averaged over."""
        return self.scenario.duration - self.settle


@dataclass(frozen=True)
class Excitation:
    """What drives a linear machine, as lines: at each frequency several experiments that do not know each other.

    The information of an output with the noise density S (one-sided) is Σ ``weights``·|∂y|²/S over lines and
    experiments, where y are outputs at the inputs' amplitudes: weights are the duration for the lines of a periodic
    signal (amplitude A: energy A²T/2 over S/2), and 2T for a constant.
    """

    frequency: Array
    """[Hz], (f,)."""
    weights: Array
    """[s], (f,)."""
    amplitudes: Array
    """Complex, (f, raw input, experiment)."""
    inputs: tuple[str, ...]
    """What the raw inputs are, as the linear model's inputs, or ``load 0``, ``load 1``, …: patterns of forces."""
