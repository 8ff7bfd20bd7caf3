"""Which test next: what each candidate would tell of each parameter, and the sequence that tells most."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.identification.planning.candidate import Bench, CandidateSettings
from ehamj.identification.planning.forecast import Lines, told_by
from ehamj.identification.planning.information import TOLD, Knowledge, best_sequence
from ehamj.identification.planning.instruments import Instruments
from ehamj.identification.planning.kinds import CANDIDATES
from ehamj.identification.planning.lanes import runs_of
from ehamj.identification.planning.linear import Linear, Machines
from ehamj.identification.planning.outcome import Forecast, Method, Plan, Step
from ehamj.identification.planning.settings import PlanSettings
from ehamj.identification.planning.trial import Trial
from ehamj.identification.unknowns import Unknown, Values
from ehamj.linear.smooth import NotSmooth
from ehamj.run.progress import Progress, silent
from ehamj.scenario.model import Scenario

LEAST: Final = 0.05
"""By how much a further test must lower the criterion: of ``d``, 5 % of all deviations."""
TOGETHER: Final = 0.3
"""Share of a parameter in a direction that is not told, from which it is named with it."""


@dataclass(frozen=True)
class Subject:
    """What is looked for, and what is known of it."""

    title: str
    machine: Scenario
    unknowns: tuple[Unknown, ...]
    at: Values
    having: Machines
    """A scenario with other values of the unknowns."""
    known: Knowledge | None = None
    """What tests that were made tell, in the scaled unknowns; without: priors and bounds alone."""
    done: tuple[str, ...] = ()
    threads: int | None = None

    @property
    def before(self) -> Knowledge:
        """What is known before the candidates."""
        return Knowledge.before(spreads(self.unknowns)) if self.known is None else self.known

    @property
    def slopes(self) -> Array:
        """A parameter's unit per scaled unknown, (k,)."""
        return np.array([one.slope(self.at[one.name]) for one in self.unknowns])


def spreads(unknowns: Sequence[Unknown]) -> Array:
    """Standard deviations before any test, scaled, (k,): of a prior, else of any value within the bounds."""
    found = []
    for one in unknowns:
        low, high = one.limits
        within = (high - low) / np.sqrt(12.0)
        prior = np.inf if one.prior is None else one.prior.deviation / one.slope(one.start)
        found.append(1.0 / np.hypot(1.0 / within, 1.0 / prior))
    return np.array(found)


def plan_tests(subject: Subject, settings: PlanSettings, progress: Progress = silent) -> Plan:
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
    predict = Predictor(subject, instruments, settings, progress)
    found = [(trial, *told) for trial in trials if (told := predict(trial)) is not None]
    before = subject.before
    forecasts = tuple(_forecast(subject, before, *one) for one in found)
    scale = spreads(unknowns)

    def cost(known: Knowledge) -> float:
        return known.cost(settings.criterion, counting, scale)

    chosen = best_sequence(before, [one.information for one in forecasts], cost, settings.tests, LEAST)
    sequence = _sequence(subject, [forecasts[k] for k in chosen], predict)
    return Plan(
        subject.title, machine, unknowns, subject.at, before.deviations * subject.slopes, subject.done, instruments,
        forecasts, predict.refused, sequence, _untold(subject, forecasts),
    )  # fmt: skip


class Predictor:
    """What a test tells, by the linear model where that serves, else by the nonlinear engine."""

    def __init__(self, subject: Subject, instruments: Instruments, settings: PlanSettings, progress: Progress) -> None:
        self._subject, self._instruments, self._settings, self._progress = subject, instruments, settings, progress
        self.refused: dict[str, str] = {}
        self._linear: Linear | None = None
        progress("linear models about the starting values")
        try:
            self._linear = Linear(subject.machine, subject.unknowns, subject.at, subject.having)
            self._why = ""
        except NotSmooth as error:
            self._why = str(error)

    def __call__(self, trial: Trial) -> tuple[Array, Method] | None:
        """Information of a test and how it was found; None where it cannot be, which `refused` then tells."""
        if self._linear is not None and trial.course != "nonlinear":
            lines = self._linear.lines(trial, self._instruments.channels, self._settings.rate)
            return self._told(lines, trial), "linear"
        if trial.course == "rest":
            self.refused[trial.name] = f"only the linear model predicts it, and there is none: {self._why}"
            return None
        information = self.nonlinear(trial)
        return None if information is None else (information, "nonlinear")

    def nonlinear(self, trial: Trial) -> Array | None:
        """Information of a test by the nonlinear engine; None where a run stops, which `refused` tells."""
        self._progress(f"simulating {trial.name}")
        short, times = shortened(trial)
        subject = self._subject
        arguments = (subject.unknowns, subject.at, subject.having, self._instruments.channels, self._settings.rate)
        try:
            lines = runs_of([short], *arguments, subject.threads)[0]
        except InputError as error:
            self.refused[trial.name] = str(error)
            return None
        return self._told(replace(lines, weights=times * lines.weights), trial)

    def _told(self, lines: Lines, trial: Trial) -> Array:
        return told_by(lines, self._instruments, trial.compared, self._settings.free)


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


def _forecast(subject: Subject, before: Knowledge, trial: Trial, information: Array, method: Method) -> Forecast:
    after = before.after(information).deviations
    return Forecast(trial, information, after * subject.slopes, before.deviations / after, method)


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
    """Parameters that all candidates together sharpen by less than `TOLD`, and what they go together with."""
    before = subject.before
    after = before.after(*(one.information for one in forecasts))
    factors = before.deviations / after.deviations
    relative = after.covariance / np.outer(before.deviations, before.deviations)
    values, vectors = np.linalg.eigh(relative)
    keys = [one.name for one in subject.unknowns]
    found = {}
    for k in np.flatnonzero(factors < TOLD):
        direction = vectors[:, int(np.argmax(values * vectors[k] ** 2))]
        others = [keys[j] for j in np.argsort(-np.abs(direction)) if j != k and abs(direction[j]) > TOGETHER]
        found[keys[k]] = (
            f"they tell it only together with {', '.join(others)}" if others else "no output depends on it enough"
        )
    return found
