"""From a scenario to a designed controller and its files."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from markupsafe import Markup

from ehamj.control.architectures.file import Law
from ehamj.control.kinds import ARCHITECTURES
from ehamj.control.settings import ControlSettings, DigitalSettings
from ehamj.design.budget import Budget, budget
from ehamj.design.kinds import DESIGNABLE, SYNTHESES
from ehamj.design.outcome import outcome
from ehamj.design.page import design_page
from ehamj.design.requirements import Machines, Requirements, behind, machines_of
from ehamj.design.synthesis import beginning, synthesised
from ehamj.design.tuning import Design, judged, tune
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.result import CONTROLLER_FILE, written_whole
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome, Progress, silent
from ehamj.studies.page import files_of, write_outcome

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
    outcome: Outcome


def design_controller(
    source: str,
    overrides: Iterable[str] = (),
    architecture: str | None = None,
    gain_margin: float = 6.0,
    phase_margin: float = 45.0,
    disk_margin: float = 0.5,
    progress: Progress = silent,
) -> Designed:
    """Design a controller for a scenario.

    A law that is held for another machine (``control.designed_for``) is designed for that one, judged on the scenario's
    own beside the variations, and predicted on that.

    Args:
        source: scenario file or shipped name.
        overrides: as `load_scenario`.
        architecture: one of `DESIGNABLE` or `SYNTHESES`; without, the scenario's own where that is a digital law
            (one without loops is judged as it is), else combined. Rate, delay and resolution are the scenario's
            controller's.
        gain_margin: least gain margin [dB].
        phase_margin: least phase margin [deg].
        disk_margin: least disk margin.
        progress: called with what is being done.

    Raises:
        InputError: if the scenario or an argument cannot be used, or no law leaves the margins.
    """
    for name, value, low, high in (
        ("gain-margin", gain_margin, 0.0, 60.0),
        ("phase-margin", phase_margin, 0.0, 89.0),
        ("disk-margin", disk_margin, 0.0, 1.9),
    ):
        if not low <= value <= high:
            raise InputError(f"--{name} {value:g}: must be from {low:g} to {high:g}")
    wanted = Requirements(gain_margin=gain_margin, phase_margin=phase_margin, disk_margin=disk_margin)
    scenario = load_scenario(source, overrides)
    given = scenario.control
    kind = _kind(given, architecture)
    if kind != given.kind:
        shared = given.shared if isinstance(given, DigitalSettings) else {}
        begin = DESIGNABLE.get(kind, DESIGNABLE["combined"]).model_copy(update=shared)
        scenario = scenario.model_copy(update={"control": begin, "compare": ("passive",)})
    believed, held = scenario.as_designed(), given.designed_for if isinstance(given, DigitalSettings) else None
    machines = dict(machines_of(believed))
    if held is not None:  # the law is derived for a machine that differs from the one it runs on
        machines[RUNS_ON] = linear_model(behind(scenario))
    if kind in SYNTHESES:
        design = synthesised(believed, machines, beginning(kind, given), wanted, progress)
        control: ControlSettings = Law(kind="law", file=CONTROLLER_FILE)
    else:
        progress("choosing crossings")
        design = _designed(believed, machines, wanted)
        control = design.settings.model_copy(update={"designed_for": held})
    scenario = scenario.model_copy(update={"control": control})
    progress("predicting what a run will show")
    limits = budget(scenario, machines.get(RUNS_ON, machines["as designed"]), design.law)
    return Designed(scenario, design, limits, outcome(scenario, kind, machines, design, limits))


def _kind(given: ControlSettings, architecture: str | None) -> str:
    """What is designed for a scenario with a ``given`` control.

    Raises:
        InputError: if the ``architecture`` that is asked for cannot be.
    """
    own = given.kind if isinstance(given, DigitalSettings) else "combined"
    if architecture in (None, own, *DESIGNABLE, *SYNTHESES):
        return architecture or own
    able = ", ".join((*DESIGNABLE, *SYNTHESES))
    more = f"; {architecture} must be stated whole, in [control]" if architecture in ARCHITECTURES else ""
    raise InputError(f"--architecture {architecture!r}: must be one of {able}{more}")


def _designed(scenario: Scenario, machines: Machines, wanted: Requirements) -> Design:
    """The scenario's own architecture with its loops tuned; one that has none is judged as it is."""
    control = scenario.control
    assert isinstance(control, DigitalSettings)
    if any(member.loops(scenario.plant) for member in control.members):
        return tune(scenario, machines, wanted)
    law = control.controller(scenario.plant, scenario.sensors)
    return replace(judged(control, law, scenario, machines, wanted), tuned=False)


def write_design(folder: Path, found: Designed) -> None:
    """Write a design into an existing folder, each file whole."""
    does = Markup(" and controller.json: <code>ehamj run scenario.toml</code> runs the machine under this law.")
    beside = Markup("{}").format(files_of(found.outcome, "design")) + does
    shown = design_page(found.outcome, found.scenario, found.design, found.limits, beside)
    write_outcome(folder, "design", found.outcome, found.scenario, shown, "design")
    with written_whole(folder / CONTROLLER_FILE) as path:
        found.design.law.save(path)
