"""Sections of the report, one file each: a function from what is shown to a `Section`, or None where it has none."""

from collections.abc import Callable
from typing import Final

from ehamj.pages import ANNEX, Section
from ehamj.report.sections.attenuation import attenuation
from ehamj.report.sections.classes import classes
from ehamj.report.sections.criteria import criteria
from ehamj.report.sections.faults import faults
from ehamj.report.sections.headline import headline, warnings, warnings_beside
from ehamj.report.sections.histories import histories
from ehamj.report.sections.inputs import inputs
from ehamj.report.sections.limits import limits, nearest
from ehamj.report.sections.loops import loops
from ehamj.report.sections.machine import machine, mounts
from ehamj.report.sections.modes import modes
from ehamj.report.sections.numbers import numbers
from ehamj.report.sections.relative import relative
from ehamj.report.sections.runs import runs_beside, runs_first
from ehamj.report.sections.spectra import spectra
from ehamj.report.sections.spectrogram import spectrogram
from ehamj.report.sections.transmissibility import transmissibility
from ehamj.report.sections.valves import valves
from ehamj.report.shown import Shown


def annex(shown: Shown) -> Section:
    """Where what a client reads ends."""
    return ANNEX


SECTIONS: Final[tuple[Callable[[Shown], Section | None], ...]] = (
    headline,
    runs_first,
    machine,
    classes,
    nearest,
    warnings,
    annex,
    faults,
    runs_beside,
    mounts,
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
    warnings_beside,
)
"""In the page's order; what stands before the annex is to fill two sheets."""
