"""Which test next: what each candidate would tell of each parameter, and the sequence that tells most."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.identification.planning.candidate import Bench, CandidateSettings
from ehamj.identification.planning.forecast import Lines, rms_of, told_by
from ehamj.identification.planning.information import TOLD, Knowledge, best_sequence
from ehamj.identification.planning.instruments import Instruments
from ehamj.identification.planning.kinds import CANDIDATES
from ehamj.identification.planning.lanes import run_of
from ehamj.identification.planning.linear import Linear
from ehamj.identification.planning.outcome import Forecast, Method, Plan, Step
from ehamj.identification.planning.settings import PlanSettings
from ehamj.identification.planning.trial import Trial
from ehamj.identification.statistics import known_before, words_of
from ehamj.identification.unknowns import Unknown, Values
from ehamj.linear.smooth import NotSmooth
from ehamj.run.progress import Progress, silent
from ehamj.scenario.model import Scenario

LEAST: Final = 0.05
"""By how much a further test must lower the criterion: of ``d``, 5 % of all deviations."""


@dataclass(frozen=True)
class Subject:
    """What is looked for, and what is known of it."""

    title: str
    machine: Scenario
    unknowns: tuple[Unknown, ...]
    at: Values
    known: Knowledge | None = None
    """What tests that were made tell, in the scaled unknowns; without: priors and bounds alone."""
    done: tuple[str, ...] = ()
    threads: int | None = None

    @property
    def before(self) -> Knowledge:
        """What is known before the candidates."""
        return Knowledge.before(self.spreads) if self.known is None else self.known

    @property
    def spreads(self) -> Array:
        """Standard deviations before any test, scaled, (k,): of a prior, else of any value within the bounds."""
        point = np.array([one.scaled(self.at[one.name]) for one in self.unknowns])
        return known_before(self.unknowns, point)

    @property
    def slopes(self) -> Array:
        """A parameter's unit per scaled unknown, (k,)."""
        return np.array([one.slope(self.at[one.name]) for one in self.unknowns])


def planned(subject: Subject, settings: PlanSettings, progress: Progress = silent) -> Plan:
    """Predict every candidate, and choose.

    Raises:
        InputError: if a candidate that the user names cannot be made, or a key, channel or limit is not allowed.
    """
    machine, unknowns = subject.machine, subject.unknowns
    instruments = Instruments.of(machine, settings.rate, settings.channels, settings.noise, settings.noise_share)
    bench = Bench(machine, settings.duration, settings.rate, settings.limits)
    counting = _counting(settings.sharpen, unknowns)
    progress("designing tests")
    trials = _distinct([one.trial(bench) for one in _candidates(settings.candidates, bench)])
    predict = Predictor(subject, bench.quiet(), instruments, settings, progress)
    found = predict.all(trials)
    before = subject.before
    forecasts = tuple(_forecast(subject, before, *one) for one in found)
    scale = subject.spreads

    def cost(known: Knowledge) -> float:
        return known.cost(settings.criterion, counting, scale)

    chosen = best_sequence(before, [one.information for one in forecasts], cost, settings.tests, LEAST)
    sequence = _sequence(subject, [forecasts[k] for k in chosen], predict)
    return Plan(
        subject.title, machine, unknowns, subject.at, before.deviations * subject.slopes, subject.done,
        predict.instruments, forecasts, predict.refused, sequence, settings, _untold(subject, forecasts),
    )  # fmt: skip


class Predictor:
    """What a test tells, by the linear model where that serves, else by the nonlinear engine."""

    def __init__(
        self, subject: Subject, machine: Scenario, instruments: Instruments, settings: PlanSettings, progress: Progress
    ) -> None:
        """``machine`` has its valves held; what the logger's converters are set for, `all` the tests tell."""
        self._subject, self._settings, self._progress = subject, settings, progress
        self.instruments = instruments
        self.refused: dict[str, str] = {}
        self._linear: Linear | None = None
        progress("linear models about the starting values")
        try:
            self._linear = Linear(machine, subject.unknowns, subject.at)
            self._why = ""
        except NotSmooth as error:
            self._why = str(error)

    def all(self, trials: Sequence[Trial]) -> list[tuple[Trial, Array, Method, tuple[str, ...]]]:
        """Information of each test that can be predicted, how it was found, and which channels move in it; `refused`
        tells of the others."""
        found = [(trial, lines, method) for trial in trials for lines, method in self._predicted(trial)]
        if not found:
            return []
        rms = np.array([rms_of(lines, self.instruments, trial.compared) for trial, lines, _ in found])
        self.instruments = self.instruments.ranged(rms.max(axis=0))
        moving = [self.instruments.moving(own) for own in rms]
        return [
            (trial, self._told(lines, trial), method, names)
            for (trial, lines, method), names in zip(found, moving, strict=True)
        ]

    def nonlinear(self, trial: Trial) -> Array | None:
        """Information of a test by the nonlinear engine; None where a run stops, which `refused` tells."""
        lines = self._simulated(trial)
        return None if lines is None else self._told(lines, trial)

    def _predicted(self, trial: Trial) -> Iterator[tuple[Lines, Method]]:
        if self._linear is not None and trial.course != "nonlinear":
            yield self._linear.lines(trial, self.instruments.channels, self._settings.rate), "linear"
        elif trial.course == "rest":
            self.refused[trial.name] = f"only the linear model predicts it, and there is none: {self._why}"
        elif (lines := self._simulated(trial)) is not None:
            yield lines, "nonlinear"

    def _simulated(self, trial: Trial) -> Lines | None:
        self._progress(f"simulating {trial.name}")
        short, times = shortened(trial)
        own = self._subject
        try:
            lines = run_of(short, own.unknowns, own.at, self.instruments.channels, self._settings.rate, own.threads)
        except InputError as error:
            self.refused[trial.name] = str(error)
            return None
        return replace(lines, weights=times * lines.weights)

    def _told(self, lines: Lines, trial: Trial) -> Array:
        return told_by(lines, self.instruments, trial.compared, self._settings.free)


def shortened(trial: Trial) -> tuple[Trial, float]:
    """A test as it need be simulated, and how many times it tells as much: one period of a multisine that has settled,
    one blow of many."""
    scenario = trial.scenario
    if trial.course == "periodic" and trial.compared > trial.settle:
        short = scenario.model_copy(update={"duration": 2.0 * trial.settle})
        return replace(trial, scenario=short), trial.compared / trial.settle
    blows = max((getattr(force, "blows", 1) for force in scenario.force), default=1)
    if trial.course == "decaying" and blows > 1:
        force = scenario.force[0].model_copy(update={"blows": 1})
        duration = min(scenario.duration, getattr(force, "interval", scenario.duration))
        return replace(trial, scenario=scenario.model_copy(update={"force": (force,), "duration": duration})), blows
    return trial, 1.0


def _candidates(given: Sequence[CandidateSettings] | None, bench: Bench) -> list[CandidateSettings]:
    return [one for kind in CANDIDATES for one in kind.usual(bench)] if given is None else list(given)


def _distinct(trials: list[Trial]) -> list[Trial]:
    """Tests whose names all differ."""
    names = [trial.name for trial in trials]
    return [
        trial
        if names.count(trial.name) == 1
        else replace(trial, name=f"{trial.name} ({1 + names[:k].count(trial.name)})")
        for k, trial in enumerate(trials)
    ]


def _counting(sharpen: Sequence[str] | None, unknowns: Sequence[Unknown]) -> list[int]:
    keys = [one.name for one in unknowns]
    for key in sharpen or ():
        if key not in keys:
            raise InputError(f"plan.sharpen: {key!r} must be one of the parameters {', '.join(keys)}")
    return [keys.index(key) for key in sharpen] if sharpen else list(range(len(keys)))


def _forecast(
    subject: Subject, before: Knowledge, trial: Trial, information: Array, method: Method, moving: tuple[str, ...]
) -> Forecast:
    after = before.after(information).deviations
    return Forecast(trial, information, after * subject.slopes, before.deviations / after, method, moving)


def _sequence(subject: Subject, chosen: Sequence[Forecast], predict: Predictor) -> tuple[Step, ...]:
    """The chosen tests one after the other, and the same by the nonlinear engine."""
    known, simulated = subject.before, subject.before
    own: dict[str, Array] = {}
    steps = []
    complete = True
    for one in chosen:
        known = known.after(one.information)
        name = one.trial.name
        if name not in own:
            again = one.information if one.method == "nonlinear" or one.trial.course == "rest" else None
            again = predict.nonlinear(one.trial) if again is None else again
            complete = complete and again is not None
            own[name] = one.information if again is None else again
        simulated = simulated.after(own[name])
        confirmed = simulated.deviations * subject.slopes if complete else None
        steps.append(Step(one, known.deviations * subject.slopes, confirmed))
    return tuple(steps)


def _untold(subject: Subject, forecasts: Sequence[Forecast]) -> dict[str, str]:
    """Parameters that tests made and all candidates together sharpen by less than `TOLD`, and what they go with."""
    spreads = subject.spreads
    after = subject.before.after(*(one.information for one in forecasts))
    factors = spreads / after.deviations
    values, vectors = np.linalg.eigh(after.covariance / np.outer(spreads, spreads))
    found = {}
    for k in np.flatnonzero(factors < TOLD):
        worst = int(np.argmax(values * vectors[k] ** 2))
        names, words = words_of(vectors[:, worst] * spreads, subject.unknowns)
        alone = names == (subject.unknowns[k].name,)
        found[subject.unknowns[k].name] = "nothing that they read depends on it enough" if alone else words
    return found
