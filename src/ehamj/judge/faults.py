"""What a fault made of a run: class, peaks, pressures and limits before it, while it settles, and after."""

from typing import Final

from ehamj.findings import Finding
from ehamj.judge.attenuation import quiet_bands
from ehamj.judge.levels import ByBand
from ehamj.judge.verdicts import Criterion

WHOLE: Final = "whole run, before and after the fault"
"""What levels of a run are of in which something failed, where its parts are not taken."""
NOTHING: Final = "nothing changes by it in this run"
"""What is said of a fault that is idle."""


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
    """Of the run, by the same estimate; empty where nothing of it has settled."""

    def in_words(self) -> str:
        """What the linear machine comes to, as the end of a sentence."""
        if not self.stable:
            return f"the linear loop with the fault is unstable: {self.pole}"
        said = quiet_bands(self.attenuation_db)
        return (
            f"the linear machine with the fault settles to a vertical attenuation of {said} (centre of gravity)"
            if said
            else ""
        )


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
    settled_s: float | None = None
    """From when on it counts as settled; None in a result that is older."""
    needed_s: float | None = None
    """Duration of a run that judges all bands of the part after; None where that part is, or another fault ends it."""
    idle: bool = False
    """Whether it changed nothing: its spool never moved, or nothing reads its sensor."""
    expected: Expectation | None
    """On the floor of the part after, or, without one, of the run so far; None where there is none: `note` says why."""
    note: str = ""

    def in_words(self) -> str:
        """When, where and what."""
        stuck = (
            "" if self.opening is None else f" (at {100 * self.opening:.2g} % of the spool's stroke)".replace("-", "−")
        )
        return f"at {self.time_s:g} s at {self.where}: {self.what}{stuck}"

    def unsettled(self, ended_s: float) -> str:
        """What is known of the time after it where that is not judged; of a run that ended at a time [s]."""
        said = ["not settled"]
        if self.settled_s is not None:
            said[0] += f", it would be judged from {self.settled_s:.4g} s on"
        if self.needed_s is not None:
            more = f"at least {self.needed_s - ended_s:.3g} s more needed (duration = {self.needed_s:g} s)"
            said.append(more)
        elif self.settled_s is not None:
            said.append(f"another fault struck before, or the run failed at {ended_s:.4g} s")
        said.append("" if self.expected is None else self.expected.in_words())
        return "; ".join(filter(None, said))
