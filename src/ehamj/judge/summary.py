"""The numbers a person asks for first: what summary.json holds, written and read by this model."""

from typing import Annotated, Any, Final

from pydantic import AfterValidator, Field

from ehamj.estimate.statistics import WORDS
from ehamj.findings import Finding
from ehamj.judge.faults import WHOLE, FaultFound, Phase
from ehamj.judge.isolation import Isolation
from ehamj.judge.learnt import Beliefs
from ehamj.judge.lines import FoundLine
from ehamj.judge.relative import RelativeMotion
from ehamj.judge.spectra import ResponseSpectra
from ehamj.judge.worse import Worse

OF_PARTS: Final = WORDS | {"rms": "RMS over each part by itself"}
"""Statistics in words, where parts of a run are judged."""

ByMount = dict[str, float]


def _levels(found: Any) -> Any:
    """Levels, checked to be numbers however deep they stand."""
    for name, level in found.items():
        if isinstance(level, dict):
            _levels(level)
        elif isinstance(level, bool) or not isinstance(level, float | int | None):
            raise ValueError(f"{name} is {level!r}; it must be a number or null")
    return found


ByChannel = Annotated[dict[str, Any], AfterValidator(_levels)]
"""Of each variable one number [its unit] per channel, nested as its dimensions are; None where it is not finite."""


class AtLimit(Finding):
    """When a limit was reached, by the recorded rows: first time and longest stretch [s], and the mount of that."""

    first_s: float
    longest_s: float
    mount: str


class Oil(Finding):
    """Oil that all mounts drew from the supply."""

    mean_flow_m3_s: float
    peak_flow_m3_s: float
    volume_m3: float
    mean_power_w: float


class PlaceMargins(Finding):
    """Margins where a loop is broken at one place, as in `ehamj.linear.margins`; None where infinite."""

    gain_db: float | None
    phase_deg: float | None
    disk: float
    peak_sensitivity: float
    peak_hz: float
    crossings_hz: list[float]


class UnstablePole(Finding):
    """The fastest growing pole of an unstable loop, as in `ehamj.linear.unstable`."""

    frequency_hz: float
    damping_ratio: float
    growth_1_s: float
    motion: str
    count: int
    words: str


class LoopMargins(Finding):
    """What a closed loop has in hand: the worst of all places, and of each motion; the pole that grows, if one does."""

    stable: bool
    gain_db: float | None
    phase_deg: float | None
    disk: float
    disk_all_valves: float
    motions: dict[str, PlaceMargins]
    unstable: UnstablePole | None = None


class Least(Finding):
    """A least margin [dB, deg or -], None where unlimited, and the machine that has it."""

    margin: float | None
    machine: str


class FoundLaw(Finding):
    """A law that was found for the machine at hand (`ehamj.synthesis`): for which, and what it has in hand there and on
    the variations that it must hold on."""

    kind: str
    mass_kg: float
    """Of the machine that it was found for, with all that is on it."""
    held: bool
    """Whether that is another than the machine that it runs on."""
    machines: int
    """On which it was judged, with that one."""
    gain_db: Least
    phase_deg: Least
    disk: Least
    seconds: float
    """That it took to find."""

    @property
    def words(self) -> str:
        """All of it as a sentence."""
        which = "the machine that it is held for" if self.held else "this machine"
        least = ((self.gain_db, ".1f", " dB"), (self.phase_deg, ".0f", "°"), (self.disk, ".2f", " disk"))
        said = [
            "unlimited" if one.margin is None else f"{one.margin:{digits}}{unit} ({one.machine})"
            for one, digits, unit in least
        ]
        return (
            f"{self.kind}, found for {which} ({self.mass_kg:.4g} kg) in {self.seconds:.1f} s; least margins of "
            f"{self.machines} machines: {', '.join(said)}"
        )


class Timing(Finding):
    """What was stepped, and how long it took; ``ratio``: simulated time over that of the stepping loop."""

    simulated_s: float
    wall_s: float
    stepping_s: float
    steps: int
    timestep_s: float
    ratio: float | None
    engine: str = "mujoco"
    """What stepped it, as the scenario's key says."""


class Head(Finding):
    """What stands at a summary's head."""

    name: str
    """Of the scenario."""
    complete: bool
    """Whether the run came to its end."""


class Summary(Isolation, Head):
    """A run in numbers, SI."""

    fault: list[FaultFound] = Field(default_factory=list)
    """What struck, in order."""
    relative: dict[str, RelativeMotion] = Field(default_factory=dict)
    response_spectrum: ResponseSpectra | None = None
    worse: list[Worse] = Field(default_factory=list)
    """Axes along which the machine moves more than the floor."""
    warnings: list[str]
    """What a reader must know, in words."""
    peak: ByChannel
    """Of each variable, about its equilibrium, one number per channel [its unit]."""
    rms: ByChannel
    """The same of the whole run."""
    saturation: dict[str, ByMount]
    """Share of the states at each limit, per mount."""
    at_limit: dict[str, AtLimit | None]
    """When each limit was reached, by the recorded rows; None: in none of them."""
    oil: Oil
    margins: LoopMargins | None
    """None without a loop, and where the law is a Python function."""
    law: FoundLaw | None = None
    """Of a law that was found for the machine at hand; None of any other."""
    made_good: tuple[str, ...] = ()
    """What of the valves the law makes good, of any mount (`ehamj.control.valves.KnownValve.makes_good`)."""
    spools: PlaceMargins | None = None
    """Margins of the loops about the spools, the worst of all valves (`ehamj.linear.spools`); None without."""
    learnt: Beliefs = Field(default_factory=dict)
    """What laws have learnt of each mount at the end; empty where they do not learn."""
    followed: list[FoundLine] = Field(default_factory=list)
    """Lines that laws follow, where they ended; empty where they follow none."""
    python_law: bool = False
    """Whether a Python function gave the commands, of which no margins are known."""
    timing: Timing
    versions: dict[str, str]
    """Of ehamj and of what it stands on."""
    seed: int
    """Of everything random."""
    failure: str | None = None
    """What went wrong, of a run that is not complete."""
    unjudged: dict[str, str] = Field(default_factory=dict)
    """What could not be judged of the run, by its key here, and why; its histories are not concerned."""

    @property
    def directions(self) -> tuple[str, ...]:
        """Names of the directions that are judged apart, the one that is the verdict first."""
        return tuple(self.criterion.verdict)

    @property
    def broken(self) -> list[FaultFound]:
        """The faults that changed something."""
        return [one for one in self.fault if not one.idle]

    @property
    def mixed(self) -> str:
        """What levels of the whole run are of, where something failed in it."""
        return WHOLE if self.broken else ""

    def parts(self) -> dict[str, Phase]:
        """The parts of the run that are judged by themselves, before and after what failed, by when they were."""
        broken = self.broken
        parts = [("before the fault", broken[0].before)] if broken else []
        parts += [(_after(one), one.after) for one in broken]
        return {
            f"{when}, {phase.from_s:.4g} to {phase.to_s:.4g} s": phase for when, phase in parts if phase is not None
        }

    def unsettled(self) -> dict[str, str]:
        """What is known of the time after each fault that is not judged, by the fault."""
        end = self.timing.simulated_s
        return {f"{_after(one)} at {one.time_s:g} s": one.unsettled(end) for one in self.broken if one.after is None}

    def lines(self, short: bool = False) -> dict[str, str]:
        """The headline, see `ehamj.judge.verdicts.Criterion.lines`; where something failed, of the parts before and
        after, since levels of the whole run are those of no machine that there was."""
        parts = self.parts()
        found = {
            f"{name} {when}": part.criterion.lines(short)[name]
            for when, part in parts.items()
            for name in self.directions
        }
        if not found:
            mixed = f", {self.mixed}" if self.mixed else ""
            return {f"{name}{mixed}": said for name, said in self.criterion.lines(short).items()} | self.unsettled()
        return found | self.unsettled() | {"judged by": self.judged_by()}

    def judged_by(self) -> str:
        """By which rule and levels, empty where nothing is; where something failed, of its parts."""
        parts = list(self.parts().values())
        return parts[0].criterion.judged_by(OF_PARTS) if parts else self.criterion.judged_by()


def _after(one: FaultFound) -> str:
    return f"after the fault at {one.where}"
