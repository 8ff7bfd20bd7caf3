"""From a scenario to a designed controller and its files."""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from markupsafe import Markup

from ehamj.control.kinds import ARCHITECTURES
from ehamj.control.settings import ControlSettings, DigitalSettings, SampledSettings
from ehamj.design.budget import Attenuations, Budget, budget
from ehamj.design.kinds import DESIGNABLE, beginning
from ehamj.design.outcome import outcome
from ehamj.design.page import design_page
from ehamj.design.tuning import tune
from ehamj.errors import DerivedAnew, InputError, did_you_mean
from ehamj.linear.machine import linear_model
from ehamj.result import CONTROLLER_FILE, written_whole
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome, Progress, silent
from ehamj.studies.page import files_of, write_outcome
from ehamj.synthesis.judged import Design, judged
from ehamj.synthesis.requirements import NOMINAL, Machines, Requirements, Variations, behind, machines_of
from ehamj.synthesis.search import synthesised
from ehamj.synthesis.settings import SynthesisSettings

DESIGN_FILES: Final = ("design.json", "design.html")
"""Files without which a folder is no design."""

RUNS_ON: Final = "the machine it runs on"
"""Name among the machines of the scenario's own, where the law is designed for another (``control.designed_for``)."""


@dataclass(frozen=True)
class Designed:
    """A scenario under its designed control, the design, and what it comes out with."""

    scenario: Scenario
    design: Design
    limits: Budget
    wrong: Attenuations
    """What is left on machines of which the law believes all wrongly at once (`Variations.all`)."""
    outcome: Outcome

    def _repr_html_(self) -> str:
        """Its answers, as a notebook shows them."""
        return self.outcome._repr_html_()


def design_controller(
    source: str,
    overrides: Iterable[str] = (),
    architecture: str | None = None,
    gain_margin: float | None = None,
    phase_margin: float | None = None,
    disk_margin: float | None = None,
    progress: Progress = silent,
) -> Designed:
    """Design a controller for a scenario.

    A law that is held for another machine (``control.designed_for``) is designed for that one, judged on the scenario's
    own beside the variations, and predicted on that.

    Args:
        source: scenario file or shipped name.
        overrides: as `load_scenario`.
        architecture: one of `DESIGNABLE`; without, the scenario's own where that is a digital law (one without loops
            is judged as it is), else combined. Rate, delay and resolution are the scenario's controller's.
        gain_margin: least gain margin [dB]; without this and the others, what the scenario's control asks for, or else
            `Requirements`.
        phase_margin: least phase margin [deg].
        disk_margin: least disk margin.
        progress: called with what is being done.

    Raises:
        InputError: if the scenario or an argument cannot be used, or no law leaves the margins.
    """
    asked = {"gain_margin": gain_margin, "phase_margin": phase_margin, "disk_margin": disk_margin}
    for (name, value), high in zip(asked.items(), (60.0, 89.0, 1.9), strict=True):
        if value is not None and not 0.0 <= value <= high:
            raise InputError(f"--{name.replace('_', '-')} {value:g}: must be from 0 to {high:g}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DerivedAnew)  # it is designed anew, which is what was asked for
        scenario = load_scenario(source, overrides)
    given = scenario.control
    kind = _kind(given, architecture)
    if kind != given.kind:
        scenario = scenario.model_copy(update={"control": beginning(kind, given), "compare": ("passive",)})
    control = scenario.control
    assert isinstance(control, DigitalSettings)
    own = control.margins if isinstance(control, SynthesisSettings) else Requirements()
    wanted = own.model_copy(update={name: value for name, value in asked.items() if value is not None})
    if isinstance(control, SynthesisSettings):
        control = control.model_copy(update={"margins": wanted})
        scenario = scenario.model_copy(update={"control": control})
    believed, held = scenario.as_designed(), control.designed_for
    machines = _machines(scenario)
    design = _designed(believed, machines, wanted, progress)
    designed = design.settings.model_copy(update={"designed_for": held})
    scenario = scenario.model_copy(update={"control": designed})
    progress("predicting what a run will show")
    limits = budget(scenario, machines.get(RUNS_ON, machines[NOMINAL]), design.law)
    wrong = {}
    for name in variations_of(designed).wrong:
        progress(f"predicting what is left with {name}")
        wrong[name] = budget(scenario, machines[name], design.law).attenuation
    return Designed(scenario, design, limits, wrong, outcome(scenario, kind, machines, design, limits, wrong))


def _kind(given: ControlSettings, architecture: str | None) -> str:
    """What is designed for a scenario with a ``given`` control.

    Raises:
        InputError: if the ``architecture`` that is asked for cannot be.
    """
    own = given.kind if isinstance(given, DigitalSettings) else "combined"
    if architecture in (None, own, *DESIGNABLE):
        return architecture or own
    more = f"; {architecture} must be stated whole, in [control]" if architecture in ARCHITECTURES else ""
    near = did_you_mean(str(architecture), DESIGNABLE)
    raise InputError(f"--architecture {architecture!r}: {near}must be one of {', '.join(DESIGNABLE)}{more}")


def variations_of(control: SampledSettings) -> Variations:
    """The machines that a control's law must hold on: as it states them, or the usual ones."""
    return control.variations if isinstance(control, SynthesisSettings) else Variations()


def _machines(scenario: Scenario) -> Machines:
    """What the law must hold on, each behind what it makes good of the valves."""
    control, nominal = scenario.control, scenario.nominal
    assert isinstance(control, DigitalSettings)
    known, outside = control.known(nominal.plant, nominal.sensors), isinstance(control, SynthesisSettings)
    machines = machines_of(nominal.plant, variations_of(control), known, outside)
    if control.designed_for is not None:  # the law is derived for a machine that differs from the one it runs on
        machines[RUNS_ON] = linear_model(behind(scenario.plant, known, outside))
    return machines


def _designed(scenario: Scenario, machines: Machines, wanted: Requirements, progress: Progress) -> Design:
    """The scenario's own architecture with its loops tuned or found; one that has none is judged as it is."""
    control, plant, sensors = scenario.control, scenario.plant, scenario.sensors
    assert isinstance(control, DigitalSettings)
    if isinstance(control, SynthesisSettings):
        return synthesised(control, plant, sensors, machines, progress)  # as a run finds it, whatever its seed
    progress("choosing crossings")
    if any(member.loops(plant) for member in control.members):
        return tune(scenario, machines, wanted)
    law = control.controller(plant, sensors)
    return replace(judged(control, law, sensors, machines, wanted, scenario.seed), tuned=False)


def write_design(folder: Path, found: Designed) -> None:
    """Write a design into an existing folder, each file whole."""
    does = Markup(" and controller.json: <code>ehamj run scenario.toml</code> runs the machine under this law.")
    beside = Markup("{}").format(files_of(found.outcome, "design")) + does
    shown = design_page(found.outcome, found.scenario, found.design, found.limits, found.wrong, beside)
    write_outcome(folder, "design", found.outcome, found.scenario, shown, "design")
    with written_whole(folder / CONTROLLER_FILE) as path:
        found.design.law.save(path)
