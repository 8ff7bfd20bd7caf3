"""Sections of the report, one file each: a function from what is shown to a `Section`, or None where it has none."""

from collections.abc import Callable
from typing import Final

from ehamj.pages import Section
from ehamj.report.sections.attenuation import attenuation
from ehamj.report.sections.criteria import criteria
from ehamj.report.sections.faults import faults
from ehamj.report.sections.headline import classes, headline, warnings
from ehamj.report.sections.histories import histories
from ehamj.report.sections.inputs import inputs
from ehamj.report.sections.limits import limits
from ehamj.report.sections.loops import loops
from ehamj.report.sections.machine import machine
from ehamj.report.sections.modes import modes
from ehamj.report.sections.numbers import numbers
from ehamj.report.sections.relative import relative
from ehamj.report.sections.runs import runs
from ehamj.report.sections.spectra import spectra
from ehamj.report.sections.spectrogram import spectrogram
from ehamj.report.sections.transmissibility import transmissibility
from ehamj.report.sections.valves import valves
from ehamj.report.shown import Shown

SECTIONS: Final[tuple[Callable[[Shown], Section | None], ...]] = (
    headline,
    classes,
    warnings,
    runs,
    faults,
    machine,
    attenuation,
    transmissibility,
    criteria,
    spectrogram,
    spectra,
    relative,
    histories,
    limits,
    valves,
    loops,
    modes,
    numbers,
    inputs,
)
"""In the page's order."""
