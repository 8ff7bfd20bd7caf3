"""Which options of the valve the data justify: fits with and without, judged by an information criterion.

Options are taken up one after the other, that one first whose effect explains most of what is left (forward selection),
and given up again where a later one makes them needless. BIC decides unless the file says otherwise: an option that is
not there lowers −2·log likelihood by χ² of one degree of freedom, which exceeds what BIC asks, the log of the number of
samples, once in a thousand times; what AICc asks, 2, once in six.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.identification.evidence import Effect, aicc, bic, deviation_of, effect_of, gain_of, samples_of
from ehamj.identification.fit import Fitted, fitted
from ehamj.identification.optional import ChoiceSettings, Place, neutral_of, places_of
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Failed, Residuals
from ehamj.identification.stepping import short_enough
from ehamj.identification.unknowns import Unknown
from ehamj.identification.verdicts import Choice, Tried, Verdict, justified, needless
from ehamj.scenario.model import Scenario

WORTH_A_FIT: Final = 0.3
"""Share of what the criterion asks, from which on a gain that was estimated to first order is worth a fit."""
BESIDE: Final = 0.5
"""Share of the best estimate from which on another option is fitted in the same round."""
BEYOND_DOUBT: Final = 4.0
"""Square of a value over its deviation, over what the criterion asks, above which it is not fitted without."""

Told = Callable[[str], None]


@dataclass(frozen=True)
class Model:
    """Parameters with some options, and where they fit best."""

    options: tuple[str, ...]
    problem: Problem
    fitted: Fitted

    @property
    def values(self) -> dict[str, float]:
        """Of all unknowns, by name."""
        return self.problem.values(self.fitted.point)


class Choosing:
    """A choice under way."""

    def __init__(
        self, settings: ChoiceSettings, machine: Scenario, tests: Sequence[Residuals], parameters: Sequence[Unknown],
        iterations: int, told: Told = lambda words: None,
    ) -> None:  # fmt: skip
        """What is chosen from.

        Args:
            settings: options that are asked for.
            machine: that the tests are compared with, as `ehamj.identification.optional.with_neutral` gives it.
            tests: see `Problem`.
            parameters: what is looked for in any case.
            iterations: of one fit, at most.
            told: hears what is done.

        Raises:
            InputError: as `places_of`.
        """
        self.settings, self.tests, self.parameters = settings, tuple(tests), tuple(parameters)
        self.places = places_of(settings, machine, [one.name for one in parameters])
        self.held = neutral_of(self.places)
        self.iterations, self.told = iterations, told
        self.tried: list[Tried] = []

    def choose(self, base: Fitted) -> tuple[Model, Choice]:
        """The model with the options that the data justify, from the fit without any, and what was tried.

        Raises:
            InputError: if the machine cannot be run with an option at any of its sizes.
        """
        model = Model((), self._problem(()), base)
        while True:
            effects = self._effects(model)
            larger = self._forward(model, effects)
            if larger is None:
                break
            model = self._backward(larger)
        model = replace(model, fitted=short_enough(model.problem, model.fitted, self.told))
        verdicts = {name: self._verdict(name, model, effects) for name in self.settings.options}
        return model, Choice(self.settings.criterion, model.options, verdicts, tuple(self.tried))

    def _effects(self, model: Model) -> dict[str, Effect]:
        """What each option that the model has not would explain, to first order, at the best of its sizes."""
        return {name: self._effect(model, name) for name in self.settings.options if name not in model.options}

    def _effect(self, model: Model, name: str) -> Effect:
        places, larger = self.places[name], self._problem((*model.options, name))
        sizes = places[0].option.sizes
        points = [self._point(larger, model.values | {at.key: at.value(size) for at in places}) for size in sizes]
        found = larger.compared(points)
        effects = [
            effect_of(model.fitted.at, one, size)
            for one, size in zip(found, sizes, strict=True)
            if not isinstance(one, Failed)
        ]
        if not effects:
            raise InputError(f"choice.options: {name!r}: the machine cannot be run with it: {found[0]}")
        best = max(effects, key=lambda one: one.gain)
        return best if best.gain > 0.0 else effects[0]

    def _forward(self, model: Model, effects: dict[str, Effect]) -> Model | None:
        """The model with one option more that the criterion likes best; None if it likes none."""
        order = sorted(effects, key=lambda name: -effects[name].gain)
        found: list[tuple[float, Model]] = []
        for name in order:
            estimated, asked = effects[name].gain, self._asked(model, len(self.places[name]))
            if estimated < WORTH_A_FIT * asked:
                self._note(model, name, estimated, False)
            elif not found or estimated > BESIDE * effects[order[0]].gain:
                other = self._fit((*model.options, name), model, effects[name])
                gain = gain_of(model.fitted.at.compared, other.fitted.at.compared) if other is not None else 0.0
                self._note(model, name, gain, True)
                if other is not None and gain > asked:
                    found.append((gain - asked, other))
        return max(found, key=lambda one: one[0])[1] if found else None

    def _backward(self, model: Model) -> Model:
        """Without the options that the last one made needless."""
        for name in model.options[:-1]:
            asked = self._asked(model, len(self.places[name]))
            if self._wald(model, name) > BEYOND_DOUBT * asked:
                continue
            without = self._fit(tuple(one for one in model.options if one != name), model, None)
            if without is None:
                continue
            gain = gain_of(without.fitted.at.compared, model.fitted.at.compared)
            if gain < asked:
                self._note(without, name, gain, True)
                self.told(f"without {name} after all")
                model = without
        return model

    def _verdict(self, name: str, model: Model, effects: dict[str, Effect]) -> Verdict:
        last = [one for one in self.tried if one.option == name][-1]
        places, criterion = self.places[name], self.settings.criterion
        if name in model.options:
            values = {place.key: self._spread(model, place) for place in places}
            return justified(places, values, last, criterion)
        return needless(places, effects[name], last, criterion)

    def _asked(self, model: Model, more: int) -> float:
        """Fall of −2·log likelihood that the criterion asks of ``more`` parameters."""
        compared = model.fitted.at.compared
        samples, known = samples_of(compared), len(model.problem.unknowns) + len(compared)
        return bic(samples, more) if self.settings.criterion == "bic" else aicc(samples, known, more)

    def _note(self, before: Model, name: str, gain: float, was_fitted: bool) -> None:
        compared, more = before.fitted.at.compared, len(self.places[name])
        samples, known = samples_of(compared), len(before.problem.unknowns) + len(compared)
        falls = gain - bic(samples, more), gain - aicc(samples, known, more)
        self.tried.append(Tried(before.options, name, gain, *falls, was_fitted))

    def _problem(self, options: Sequence[str]) -> Problem:
        own = [place.unknown for name in options for place in self.places[name]]
        return Problem(self.tests, (*self.parameters, *own), held=self.held)

    def _point(self, problem: Problem, values: dict[str, float]) -> Array:
        """Scaled unknowns of a problem at these values."""
        return np.array([one.scaled(values[one.name]) for one in problem.unknowns])

    def _fit(self, options: tuple[str, ...], model: Model, effect: Effect | None) -> Model | None:
        """The fit with these options, begun where ``model`` is; None where it cannot be run."""
        problem, values = self._problem(options), model.values
        if effect is not None:
            values |= {at.key: _within(at.value(effect.best), at) for at in self.places[options[-1]]}
        self.told(f"with {', '.join(options) or 'no option'}")
        found = fitted(problem, self._point(problem, values), self.iterations, told=self.told)
        return None if isinstance(found, Failed) else Model(options, problem, found)

    def _spread(self, model: Model, place: Place) -> tuple[float, float]:
        """An option's value and its standard deviation, errors taken as white."""
        k = [one.name for one in model.problem.unknowns].index(place.key)
        value = model.values[place.key]
        return value, model.problem.unknowns[k].slope(value) * deviation_of(model.fitted.at, k)

    def _wald(self, model: Model, name: str) -> float:
        """Square of an option's value over its deviation, of the isolator that has most of it."""
        spreads = [(self._spread(model, place), place) for place in self.places[name]]
        return max(((value - place.value(0.0)) / deviation) ** 2 for (value, deviation), place in spreads)


def _within(value: float, place: Place) -> float:
    """A value well within the bounds."""
    low, high = (place.value(size) for size in place.option.bounds)
    return min(max(value, low + 1e-3 * (high - low)), high - 1e-3 * (high - low))
