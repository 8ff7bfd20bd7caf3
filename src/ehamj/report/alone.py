"""The report's figures one by one, as axes: what ``result.plot`` gives."""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from ehamj import plots
from ehamj.errors import InputError, did_you_mean
from ehamj.pages import Picture
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES
from ehamj.report.sections.attenuation import figures_of as of_attenuation
from ehamj.report.sections.criteria import figures_of as of_criteria
from ehamj.report.sections.criteria import views_of
from ehamj.report.sections.histories import HISTORIES
from ehamj.report.sections.histories import figures_of as of_histories
from ehamj.report.sections.spectrogram import figures_of as of_spectrogram
from ehamj.report.sections.transmissibility import figures_of as of_transmissibility
from ehamj.report.shown import Shown
from ehamj.result import Result, side_by_side

if TYPE_CHECKING:
    from matplotlib.axes import Axes
else:
    Axes = Any


class Plots:
    """Figures of a result, or of several beside each other; each is drawn when it is asked for.

    Every method gives the uppermost axes of a figure in the house style; ``axes.figure`` is the figure, and a notebook
    that is given the axes shows it. What several figures need is computed once: keep the object for more than one.

    ``results`` are by label, the first is the one that is asked about.
    """

    def __init__(self, *results: Result) -> None:
        self.results = side_by_side(results, "draw")
        self._shown = Shown.of(self.results)

    def __repr__(self) -> str:
        drawn = "attenuation, criteria, histories, transmissibility, spectrogram"
        return f"Figures of {', '.join(self.results)}: {drawn}; beside(result) draws others with it"

    def beside(self, *others: Result) -> "Plots":
        """The same figures with other results beside this one: ``result.plot.beside(passive).attenuation()``."""
        return Plots(*self.results.values(), *others)

    def attenuation(self, axis: str = "z") -> Axes:
        """How much quieter than its floor the machine is, in third-octave bands [dB].

        Args:
            axis: x, y or z of the centre of gravity, or the rotation rx, ry or rz.

        Raises:
            InputError: if the axis is none, or nothing is known along it.
        """
        _check("attenuation: axis", axis, AXIS_NAMES)
        found = of_attenuation(self._shown, [axis])
        return _axes(found, f"attenuation: axis = {axis!r}", "the floor moves too little there, or the run is short")

    def criteria(self, axis: str = "z", norm: str | None = None) -> Axes:
        """Velocity of floor and machine in third-octave bands [µm/s] against the classes of a norm.

        Args:
            axis: x, y or z; of a norm that judges both horizontal axes as one, xy or z.
            norm: one of ``scenario.criteria.norms``; the first where it is left out.

        Raises:
            InputError: if the norm judged nothing, the axis is none of its, or nothing moves along it.
        """
        norm = next(iter(self._shown.norms)) if norm is None else norm
        _check("criteria: norm", norm, self._shown.norms)
        _check("criteria: axis", axis, views_of(norm))
        found = of_criteria(self._shown, norm, self._shown.norms[norm], [axis])
        return _axes(found, f"criteria: axis = {axis!r}", "nothing moves along it, or the norm has no curves")

    def histories(self, quantity: str = "velocity") -> Axes:
        """What happened over time: the whole run, and its characteristic part below.

        Args:
            quantity: velocity [µm/s] of floor and machine, or what belongs to the mounts: stroke [µm], command [V],
                spool [mA], flow [l/min], pressure [bar].

        Raises:
            InputError: if the quantity is none, or there is none of it.
        """
        _check("histories: quantity", quantity, HISTORIES)
        found = of_histories(self._shown, [quantity])
        return _axes(found, f"histories: quantity = {quantity!r}", "it is zero at all times")

    def transmissibility(self, axis: str = "z") -> Axes:
        """Machine over floor [-]: linear, and measured from the run.

        Args:
            axis: x, y or z, or the rotation rx, ry or rz.

        Raises:
            InputError: if the axis is none, or the floor of the run does not excite it.
        """
        _check("transmissibility: axis", axis, AXIS_NAMES)
        found = of_transmissibility(self._shown, [axis])
        return _axes(found, f"transmissibility: axis = {axis!r}", "the floor of this run does not excite it")

    def spectrogram(self, axis: str = "z") -> Axes:
        """Third-octave velocity of floor and machine over time [µm/s].

        Args:
            axis: x, y or z.

        Raises:
            InputError: if the axis is none, or nothing moves along it.
        """
        _check("spectrogram: axis", axis, CRITERION_AXES)
        found = of_spectrogram(self._shown, [axis])
        return _axes(found, f"spectrogram: axis = {axis!r}", "nothing moves along it, or the run is short")


def _check(key: str, value: str, allowed: Iterable[str]) -> None:
    allowed = list(allowed)
    if value not in allowed:
        near = did_you_mean(str(value), allowed)
        raise InputError(f"{key} = {value!r}: {near}must be one of {', '.join(allowed)}")


def _axes(pictures: Iterator[Picture], asked: str, why: str) -> Axes:
    """The axes of the first figure, which a notebook shows as it stands in the report."""
    picture = next(pictures, None)
    if picture is None:
        raise InputError(f"{asked}: there is nothing to draw: {why}")
    axes: Any = picture.figure.axes[0]
    axes._repr_svg_ = partial(plots.svg, picture.figure, picture.id)
    found: Axes = axes
    return found
