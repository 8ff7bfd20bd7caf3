"""What is wrong with a channel beside the model, before anything is fitted: its unit, its sign, its clock.

Machines about the start are predicted, of which one is near the true one. A channel is doubted where it goes with none
of them as it is, and with some of them well if it were otherwise: so a machine that differs by a third is none.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.residual import Compared, Failed, Residuals, real
from ehamj.identification.unknowns import Unknown, Values
from ehamj.measured.alike import likeness
from ehamj.measured.measured import Measured
from ehamj.scenario.model import Scenario

DRAWN: Final = 16
"""Machines beside that of the start."""
ABOUT: Final = 0.35
"""Share by which their values differ at most."""
BETTER: Final = 0.25
"""By how much better it must go if it were otherwise."""
BETTER_STILL: Final = 0.1
"""By how much better later than turned: half a period of a swing does the same to it as its sign, but for its ends."""
OPPOSED: Final = -0.4
"""Correlation of two predictions below which a channel's sign hangs on the machine."""
UNLIKE: Final = 8.0
"""Ratio of sizes of predictions above which it may turn within a little more."""
LATE: Final = 0.5
"""Delay that is looked for, earlier or later [s]."""
CERTAIN: Final = 8e-3
"""Delay from which it is none of a mode whose frequency is not yet known [s]; smaller ones show after the fit
(`ehamj.identification.lateness`)."""
KNOWN: Final = 0.4
"""The same of responses, over the time after which their lines repeat."""
FREE: Final = 0.02
"""Delay that is found by the fit where a channel's is free [s]."""
UNITS: Final[dict[str, tuple[tuple[float, str], ...]]] = {
    "Pa": ((1e5, "bar for Pa"), (1e3, "kPa for Pa"), (1e6, "MPa for Pa"), (6894.76, "psi for Pa"),
           (14.504, "bar for psi")),
    "m": ((1e-3, "mm for m"), (1e-6, "µm for m"), (0.0254, "inches for m"), (25.4, "inches for mm")),
    "m/s": ((1e-3, "mm/s for m/s"), (1e-6, "µm/s for m/s"), (0.0254, "in/s for m/s")),
    "m/s²": ((9.80665, "g for m/s²"), (1e-3, "mm/s² for m/s²")),
    "mA": ((1e3, "A for mA"),),
}  # fmt: skip
"""True over written, and what was taken for what; the other way round too."""


class Sure(NamedTuple):
    """From when on something is told."""

    otherwise: float
    """Factor on every prediction from which a channel's unit is doubted."""
    well: float
    """Correlation from which a channel goes well with a prediction."""


DRAWN_ONES: Final = Sure(2.5, 0.6)
"""Beside many machines, of which one is near."""
FOUND: Final = Sure(6.0, 0.8)
"""Beside the one that was found, of which what is held fixed may be wrong."""


class Doubt(NamedTuple):
    """Something wrong with a channel."""

    test: str
    channel: str
    said: str


class _Beside(NamedTuple):
    """A channel beside one prediction."""

    size: float
    """RMS of measured over that of predicted."""
    as_is: float
    """Correlation, −1 to 1."""
    best: float
    """Size of the correlation at the best delay."""
    delay: float
    """[s]"""


def doubts(tests: Sequence[Residuals], parameters: Sequence[Unknown], held: Values) -> list[Doubt]:
    """What is wrong with the channels of some tests, those held out too; nothing of those that cannot be predicted.

    Args:
        tests: that are to be fitted, or validate.
        parameters: that are looked for.
        held: values of other keys that tests are told.
    """
    found: list[Doubt] = []
    machines = _machines(parameters)
    for test in tests:
        own = {one.name: one.start for one in test.unknowns}
        ran = [at for at in test.rough([{**held, **one, **own} for one in machines]) if not isinstance(at, Failed)]
        of_test: dict[str, str] = {}
        for channels in zip(*ran, strict=True):
            channel = channels[0].name.partition(" / ")[0]  # of several inputs the first that shows it
            if channel not in of_test and (said := _doubt(channels)):
                of_test[channel] = said
        found += [Doubt(test.name, channel, said) for channel, said in of_test.items()]
    return found


def doubts_at(tests: Sequence[str], compared: Sequence[Compared], known: Sequence[Doubt]) -> list[Doubt]:
    """What seems wrong with channels beside the machine that was found: of one whose motion goes with no machine near
    the start, such as a foot's across, this is seen only now; what is held fixed may be wrong as well.

    Args:
        tests: name of each channel's test.
        compared: channels at the end of the fit.
        known: doubts that were found before.
    """
    found = {(one.test, one.channel): one.said for one in known}
    for test, channel in zip(tests, compared, strict=True):
        name = channel.name.partition(" / ")[0]
        if (test, name) not in found and (said := _doubt([channel], FOUND)):
            found[test, name] = said
    return [Doubt(*place, said) for place, said in found.items()][len(known) :]


def undriven(machine: Scenario, measured: Mapping[str, object]) -> list[str]:
    """Valves whose commands a record leaves out that has those of others, in words: what they did would be taken
    for what the machine is."""
    found = []
    for name, record in measured.items():
        given = {one.name for one in record.inputs} if isinstance(record, Measured) else set[str]()
        commands = [f"valve_command {mount}" for mount in machine.plant.obeying.mounts]
        missing = [one for one in commands if one not in given]
        if 0 < len(missing) < len(commands):
            found.append(f"test {name!r}: {', '.join(missing)}: not in its measurement; these valves count as at rest")
    return found


def _machines(parameters: Sequence[Unknown]) -> list[Values]:
    """The start, and machines about it, within the bounds."""
    from scipy.stats.qmc import Sobol

    shares = Sobol(len(parameters), rng=np.random.default_rng(0)).random(DRAWN)
    low = np.array([max(one.low, one.start - ABOUT * abs(one.start)) for one in parameters])
    high = np.array([min(one.high, one.start + ABOUT * abs(one.start)) for one in parameters])
    drawn = [[one.start for one in parameters], *(low + shares * (high - low)).tolist()]
    return [{one.name: value for one, value in zip(parameters, values, strict=True)} for values in drawn]


def _doubt(channels: Sequence[Compared], sure: Sure = DRAWN_ONES) -> str:
    """What is wrong with a channel beside all predictions, in words; empty where nothing is."""
    beside = [found for one in channels if (found := _beside(one)) is not None]
    free = {name.rpartition(".")[2] for name in channels[0].slopes}
    if not beside:
        return ""
    if not _delicate(channels):
        as_is, best = max(one.as_is for one in beside), max(beside, key=lambda one: one.best)
        turned = max(-one.as_is for one in beside)
        late = best.best > max(sure.well, as_is + BETTER, turned + BETTER_STILL) and abs(best.delay) > CERTAIN
        if turned > max(sure.well, as_is + BETTER) and not late:
            return "is the wrong way round: its sign is reversed (scale = -1 turns it)"
        if late and abs(best.delay) > (FREE if "delay" in free else CERTAIN):
            words = "late" if best.delay > 0.0 else "early"
            way = "; its delay is free within 20 ms only" if "delay" in free else ""
            return f"comes {1e3 * abs(best.delay):.3g} ms too {words}: clocks are not synchronised{way}"
    likely = [one.size for one in beside if one.best > sure.well]
    if "gain" in free or not likely:
        return ""
    sizes = [one.size for one in beside]
    least, most, spread = min(likely), max(likely), float(np.sqrt(max(sizes) / min(sizes)))
    if least > sure.otherwise * spread or most < 1.0 / sure.otherwise / spread:
        size = float(np.exp(np.mean(np.log(likely))))
        return f"is {size:.2g} times as large as the model has it{_unit(channels[0].unit, size)}"
    return ""


def _delicate(channels: Sequence[Compared]) -> bool:
    """Whether some of the machines have a channel the other way round than others, or many times as large, so that its
    sign tells nothing: such is a foot's motion across, which the height of the centre of gravity turns."""
    about = [np.asarray(values - values.mean()) for values in (real(one.predicted) for one in channels)]
    sizes = np.array([np.linalg.norm(values) for values in about])
    if not sizes.min() > 0.0 or sizes.max() > UNLIKE * sizes.min():
        return True
    return any(float(about[0] @ one) < OPPOSED * float(sizes[0] * size) for one, size in zip(about, sizes, strict=True))


def _unit(unit: str, size: float) -> str:
    """The mistake that is likely where samples are so many times too large."""
    known = UNITS.get(unit.replace("^2", "²"), ())
    both = [(1.0 / true, f"as if {words.replace(' for ', ' were taken for ')}") for true, words in known]
    both += [(true, "as if {1} were taken for {0}".format(*words.split(" for "))) for true, words in known]
    near = [(abs(np.log(size / factor)), words) for factor, words in both if abs(np.log(size / factor)) < np.log(3.0)]
    return f", {min(near)[1]}: state its unit" if near else ": state its unit, or let its gain be free"


def _beside(one: Compared) -> _Beside | None:
    measured, predicted = one.measured, one.predicted
    if one.axis == "time" and len(one.at) > 50:
        rate = (len(one.at) - 1) / float(one.at[-1] - one.at[0])
        found = likeness(np.asarray(predicted.real), np.asarray(measured.real), rate, LATE)
        size = float(np.std(measured) / np.std(predicted)) if np.std(predicted) > 0.0 else 0.0
        return _Beside(size, found.undelayed, found.correlation, found.delay) if size > 0.0 else None
    if one.axis == "frequency" and len(one.at) > 10:
        return _responses(one.at, measured, predicted)
    return None


def _responses(hertz: Array, measured: Array | ComplexArray, predicted: Array | ComplexArray) -> _Beside | None:
    """Of responses, each line over its size, so that resonances are not all that counts."""
    size = np.abs(predicted)
    if not (size > 0.0).all() or not np.any(measured):
        return None
    ratio = np.asarray(measured / predicted, complex)
    shares = ratio / max(float(np.sqrt(np.mean(np.abs(ratio) ** 2))), 1e-300)
    delays, turns = _turns(hertz.tobytes())
    sizes = (turns @ shares).real / shares.size
    k = int(np.argmax(np.abs(sizes)))
    as_is = float(np.mean(shares).real)
    return _Beside(float(np.median(np.abs(ratio))), as_is, float(abs(sizes[k])), float(delays[k]))


@lru_cache(4)
def _turns(frequencies: bytes) -> tuple[Array, ComplexArray]:
    """Delays [s], and what undoes each at frequencies [Hz], (delay, f)."""
    hertz = np.frombuffer(frequencies)
    spacing = float(np.median(np.diff(hertz)))
    reach = min(LATE, KNOWN / spacing)
    delays = np.arange(-reach, reach, 1.0 / (4.0 * float(hertz[-1])))
    return delays, np.exp(2j * np.pi * np.outer(delays, hertz))
