"""Run one scenario: prepare → drive → observe → summarise."""

import time as clock
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ehamj.belonging import RUN
from ehamj.control import as_controller
from ehamj.control.architectures.file import Law
from ehamj.ground.shared import Floors
from ehamj.mujoco import hydraulics
from ehamj.mujoco.model import drawn_xml
from ehamj.run.drive import Driven, Progress, drive
from ehamj.run.judging import import_judging
from ehamj.run.prepare import Prepared, prepare
from ehamj.run.side_by_side import drive_block, small
from ehamj.run.stream import Stream, streamed
from ehamj.scenario.load import Given, as_scenario
from ehamj.scenario.model import Scenario

if TYPE_CHECKING:
    import xarray as xr

    from ehamj.growing import Kept
    from ehamj.result import Result


def simulate(
    scenario: Given,
    progress: Progress | None = None,
    controller: Any = None,
    *,
    floors: Floors | None = None,
    within: Path | None = None,
) -> "Result":
    """Run a scenario.

    Rows that are too many for memory go to a file as they come. The result's channels are then read from it when they
    are asked for; it goes when nobody holds them any more.

    Args:
        scenario: what to simulate: a scenario, a shipped name, a file, or a table (`ehamj.parse_scenario`).
        progress: called now and then with the fraction done.
        controller: runs instead of the scenario's control: a `ehamj.Controller`, a bank of them, a
            `ehamj.PythonController`, the file of a law, or a python-control system with ``dt`` and channels as input
            labels.
        floors: that it shares with other runs (`ehamj.ground.shared`); ground channels of the result are then shared
            too, and read-only.
        within: folder for such a file, by default the system's for what is temporary; where a result is saved on the
            same file system, that takes no time.

    Raises:
        InputError: if the scenario cannot be run as it is.
        Incomplete: if the simulation fails; its ``result`` holds what was computed until then.
    """
    with hydraulics():
        return stepped(ready(as_scenario(scenario), controller, floors, within), progress)


class Ready(NamedTuple):
    """A run that has not begun, and that nothing refuses any more."""

    prepared: Prepared
    controller: Any
    """What runs instead of the scenario's control, as it was given."""
    seconds: float
    """That preparing it took [s]."""


def ready(
    scenario: Scenario, controller: Any = None, floors: Floors | None = None, within: Path | None = None
) -> Ready:
    """A scenario made ready to step, arguments and errors as of `simulate`; call it with the hydraulics installed."""
    began = clock.perf_counter()
    law = None if controller is None else as_controller(controller)
    prepared = prepare(scenario, law, floors, within)
    return Ready(prepared, controller, clock.perf_counter() - began)


def stepped(run: Ready, progress: Progress | None = None) -> "Result":
    """The result of a run that was made ready; call it with the hydraulics that it was made ready with.

    Raises:
        Incomplete: as `simulate`.
    """
    began = clock.perf_counter() - run.seconds
    return judged(seen(run.prepared, driven_alone(run.prepared, progress)), began, run.controller)


class Observed(NamedTuple):
    """A run that nobody has judged: its channels, and what they came from."""

    prepared: Prepared
    driven: Driven
    dataset: "xr.Dataset"
    failed: str | None
    """What went wrong, in words; None where nothing did."""
    kept: "Kept | None" = None
    """The file of its channels, where they are too many for memory."""

    @property
    def scenario(self) -> Scenario:
        """What was simulated."""
        return self.prepared.scenario


def observed(scenario: Scenario, controller: Any = None) -> Observed:
    """As `simulate`, without a summary, which takes longer than most short runs."""
    began = clock.perf_counter()
    with hydraulics():
        prepared = ready(scenario, controller).prepared
        run = seen(prepared, driven_alone(prepared))
    if run.failed is not None:
        judged(run, began, controller)  # raises
    return run


def driven_alone(prepared: Prepared, progress: Progress | None = None) -> Driven:
    """What the stepping loop of its engine left of a run; call it with the hydraulics installed."""
    if prepared.scenario.engine == "mujoco":
        return drive(prepared, progress)
    return next(drive_block([prepared], [small(prepared)], progress))


def seen(prepared: Prepared, driven: Driven) -> Observed:
    """A run from what the stepping loop left of it; what reads it is imported here."""
    import_judging()
    from ehamj.run.failures import failure
    from ehamj.run.observe import identity, observe

    if driven.stream is not None:
        return _in_a_file(prepared, driven, driven.stream)
    assert driven.rows is not None
    dataset = None
    with suppress(Exception):  # which holds what was made until then: it goes first
        dataset = observe(prepared, driven.rows, driven.struck)
    if dataset is None:  # a part at a time takes less memory, and those before one that fails are kept
        return _in_a_file(prepared, driven, streamed(prepared, driven.rows, driven.struck))
    failed = failure(prepared, driven.stopped, dataset, driven.lost)
    dataset.attrs |= {"complete": int(failed is None), RUN: identity(prepared, dataset)}
    return Observed(prepared, driven, dataset, failed)


def _in_a_file(prepared: Prepared, driven: Driven, stream: Stream) -> Observed:
    kept, failed = stream.ended(driven.stopped, driven.lost)
    return Observed(prepared, driven, kept.dataset, failed, kept)


def judged(run: Observed, began: float, controller: Any) -> "Result":
    """The result of a run that began at a time of the clock [s]; raises `Incomplete` of one that failed."""
    import_judging()
    from ehamj.result import CONTROLLER_FILE, Result
    from ehamj.run.failures import Incomplete
    from ehamj.run.summarise import summarise

    prepared, scenario, law = run.prepared, run.scenario, run.prepared.law
    summary = summarise(prepared, run.driven, run.dataset, clock.perf_counter() - began, run.failed)
    if law is not None and (controller is not None or isinstance(scenario.control, Law)):
        scenario = scenario.model_copy(update={"control": Law(kind="law", file=CONTROLLER_FILE)})
    result = Result(scenario, run.dataset, summary, drawn_xml(scenario.plant, prepared.timestep), law, run.kept)
    if run.failed is not None:
        raise Incomplete(run.failed, result) from next(iter(prepared.loop.failures), None)
    return result
