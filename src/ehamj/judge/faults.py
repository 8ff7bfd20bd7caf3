"""What a fault made of a run: class, peaks, pressures and limits before it, while it settles, and after."""

from ehamj.findings import Finding
from ehamj.judge.levels import ByBand
from ehamj.judge.verdicts import Criterion


class Pressures(Finding):
    """Lowest and highest pressure of a mount's chambers [Pa]."""

    lowest: float | None
    highest: float | None


class Phase(Finding):
    """A part of a run: what was judged there, and how near its limits it came."""

    from_s: float
    to_s: float
    criterion: Criterion
    """By the first norm; while a fault settles by the largest sliding 1 s RMS, with one second before it."""
    attenuation_db: ByBand
    """Vertical, of the whole part, band → dB."""
    peak_velocity: dict[str, dict[str, float | None]]
    """Place → axis → peak [m/s]; of floor and feet the worst mount's."""
    stroke: dict[str, float | None]
    """Mount → largest stroke from where it stood at rest [m]."""
    pressure: dict[str, Pressures]
    """Mount → its chambers."""
    saturation: dict[str, dict[str, float]]
    """Share of the recorded rows at each limit, per mount."""


class Expectation(Finding):
    """What the linear machine with the fault does on the floor of the part after it, beside what the run did there."""

    stable: bool
    pole: str | None = None
    """What grows, of an unstable loop."""
    attenuation_db: ByBand
    """Vertical, linear, band → dB; empty where the loop is unstable."""
    run_db: ByBand
    """Of the run, by the same estimate."""


class FaultFound(Finding):
    """A fault that struck a run."""

    kind: str
    where: str
    time_s: float
    """Of the step from which on it acted."""
    what: str
    opening: float | None = None
    """Where the spool stuck, as share of its stroke; of a valve that did."""
    channels: list[str]
    """Readings of the law that it changed."""
    before: Phase | None
    during: Phase | None
    """While it settled; None of a run that ended at once."""
    after: Phase | None
    """None where it had no time to settle."""
    expected: Expectation | None
    """None where there is nothing to compare with; `note` says why."""
    note: str = ""

    def in_words(self) -> str:
        """When, where and what."""
        stuck = (
            "" if self.opening is None else f" (at {100 * self.opening:.2g} % of the spool's stroke)".replace("-", "−")
        )
        return f"at {self.time_s:g} s at {self.where}: {self.what}{stuck}"
