"""From a run and its channels to its summary."""

from typing import Any

import xarray as xr

from ehamj.control import LinearController, PythonController
from ehamj.errors import InputError
from ehamj.findings import finite
from ehamj.judge.extremes import peak_and_rms
from ehamj.judge.faults import FaultFound
from ehamj.judge.isolation import Isolation, isolation
from ehamj.judge.levels import duration_of
from ehamj.judge.lines import beyond
from ehamj.judge.relative import relative_motions
from ehamj.judge.spectra import response_spectra
from ehamj.judge.summary import FoundLaw, Least, LoopMargins, PlaceMargins, Summary, Timing
from ehamj.judge.worse import Worse
from ehamj.linear.loop import Loop, closed_at_rest, feeds_back, linear_under
from ehamj.linear.margins import report
from ehamj.linear.smooth import NotSmooth, used_options
from ehamj.linear.spools import spool_margins
from ehamj.run.aftermath import aftermath
from ehamj.run.aftermath import warnings as told
from ehamj.run.deciding import clipped_when_it_counts
from ehamj.run.drive import Driven
from ehamj.run.learnt import found_lines, learnt, unlearnt
from ehamj.run.limits import at_limit, oil, saturation, warnings
from ehamj.run.observe import versions
from ehamj.run.prepare import Prepared
from ehamj.run.reserves import reserves
from ehamj.run.unjudged import Judging
from ehamj.run.why import worsened
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import unlike

UNSTABLE = "the control loop is unstable: the linear machine runs away under this law"


def summarise(prepared: Prepared, driven: Driven, dataset: xr.Dataset, seconds: float, failure: str | None) -> Summary:
    """The numbers a person asks for first; what cannot be judged is named in ``unjudged``, and all else is there.

    Args:
        prepared: what was simulated.
        driven: what the stepping loop left.
        dataset: its channels.
        seconds: that the simulation took in all [s].
        failure: what went wrong, in words; None where nothing did.
    """
    scenario, plant, steps = prepared.scenario, prepared.scenario.plant, driven.stopped.steps
    rate, usable_to = scenario.record_rate, prepared.motion.usable_to
    # Counted: one state before each step and, at the end of a complete run, the last one.
    states = max(steps + (failure is None), 1)
    shares = saturation(driven.tally, states, plant.mounts)
    judging = Judging()
    part = judging.of

    isolated, undecided = part(
        "isolation", lambda: _isolated(prepared, dataset), lambda: _isolated(prepared, dataset.isel(time=slice(0)))
    )
    clipped = part(
        "clipping", lambda: clipped_when_it_counts(dataset, plant, rate, isolated.criterion, prepared.law), list[str]
    )
    margins, doubts = part("margins", lambda: loop_margins(scenario, prepared.law), lambda: (None, []))
    unstable = margins is not None and not margins.stable
    louder = part("worse", lambda: worsened(prepared, dataset, isolated, shares, unstable), list[Worse])
    limits = [*warnings(shares), *clipped, *part("reserves", lambda: reserves(dataset, plant), list[str])]
    peak, rms = part("peak, rms", lambda: peak_and_rms(dataset), lambda: ({}, {}))
    simulated = duration_of(dataset)
    asked: dict[str, Any] = {"law": _found(prepared)} | ({} if failure is None else {"failure": failure})
    struck = part("fault", lambda: aftermath(prepared, driven.struck, dataset), list[FaultFound])
    asked |= {"fault": struck} if struck else {}
    judged = [*undecided, *(one.in_words() for one in louder)] if failure is None else []  # nothing is of a part of it
    found, idle = part("learnt", lambda: _learnt(prepared, dataset), lambda: ({}, []))
    about, swings = part("spools", lambda: loops_about_spools(scenario, prepared.law), lambda: (None, []))
    asked |= found if about is None else found | {"spools": about}
    asked |= _asked_for(scenario, dataset, usable_to, judging)
    limited = part("at_limit", lambda: at_limit(dataset, plant, rate), dict)
    said = [*judging.warnings, *told(struck), *prepared.notes, *doubts, *swings, *judged, *limits, *idle]
    if judging.lost:
        asked["unjudged"] = judging.lost
    return Summary(
        name=scenario.name,
        complete=failure is None,
        **isolated,
        **asked,
        warnings=said,
        worse=louder,
        peak=peak,
        rms=rms,
        saturation=shares,
        at_limit=limited,
        oil=oil(driven.tally, states, steps * prepared.timestep),
        margins=margins,
        python_law=isinstance(prepared.controller, PythonController),
        timing=_timing(prepared, driven, simulated, seconds),
        versions=dict(versions()),
        seed=scenario.seed,
    )


def _isolated(prepared: Prepared, dataset: xr.Dataset) -> tuple[Isolation, list[str]]:
    """How the machine is isolated, by some rows of the run."""
    scenario, motion = prepared.scenario, prepared.motion
    return isolation(
        dataset, scenario.plant, scenario.record_rate, motion.usable_to, prepared.norms, motion.usable_from
    )


def _timing(prepared: Prepared, driven: Driven, simulated: float, seconds: float) -> Timing:
    """What was stepped of ``simulated`` time, and in how many ``seconds`` in all."""
    return Timing(
        simulated_s=simulated,
        wall_s=seconds,
        stepping_s=driven.seconds,
        steps=driven.stopped.steps,
        timestep_s=prepared.timestep,
        ratio=simulated / driven.seconds if driven.seconds > 0 else None,
        engine=prepared.scenario.engine,
    )


def _asked_for(scenario: Scenario, dataset: xr.Dataset, usable_to: float, judging: Judging) -> dict[str, Any]:
    """What a scenario asks to be judged beside the usual."""
    asked: dict[str, Any] = {}
    rate, spectrum = scenario.record_rate, scenario.criteria.response_spectrum
    if scenario.relative:
        asked["relative"] = judging.of(
            "relative", lambda: relative_motions(dataset, scenario.relative, rate, usable_to), dict
        )
    if spectrum is not None:
        asked["response_spectrum"] = judging.of(
            "response_spectrum", lambda: response_spectra(dataset, rate, usable_to, spectrum), lambda: None
        )
    return asked


def _found(prepared: Prepared) -> FoundLaw | None:
    """How the law was found, where it was found for the machine at hand."""
    found, scenario = prepared.found, prepared.scenario
    if found is None:
        return None
    least = (Least(margin=finite(margin), machine=machine) for margin, machine in found.design.least)
    return FoundLaw(
        kind=scenario.control.kind,
        mass_kg=found.nominal.plant.machine.mass,
        held=bool(unlike(scenario.nominal, scenario.installation)),
        machines=len(found.design.reports),
        seconds=found.seconds,
        **dict(zip(("gain_db", "phase_deg", "disk"), least, strict=True)),
    )


def _learnt(prepared: Prepared, dataset: xr.Dataset) -> tuple[dict[str, Any], list[str]]:
    """What its law makes good, has learnt in a run, and where its lines were; and what must be said of mounts of which
    it learnt nothing and of lines that may be elsewhere."""
    if prepared.controller is None:
        return {}, []
    converter, lines = prepared.controller.converter, found_lines(dataset, prepared.controller)
    beliefs = learnt(dataset, converter)
    good = dict.fromkeys(words for valve in converter.valves for words in valve.makes_good)
    return {"learnt": beliefs, "followed": lines, "made_good": tuple(good)}, [
        *unlearnt(beliefs, converter),
        *beyond(lines),
    ]


def loops_about_spools(scenario: Scenario, law: LinearController | None) -> tuple[PlaceMargins | None, list[str]]:
    """Least margins of the loops about the spools, and what must be said of those that are unstable; None without."""
    found = spool_margins(scenario.plant, law, scenario.sensors)
    wild = [mount for mount, one in found.items() if one is None]
    stable = [one for one in found.values() if one is not None]
    said = [
        f"the loop about the spool is unstable with the valves of {', '.join(wild)} as they are; lower "
        "control.spool_feedback.crossing, or hold the law for these valves"
    ] if wild else []  # fmt: skip
    if not stable:
        return None, said
    return PlaceMargins.model_validate(min(stable, key=lambda one: one.disk).to_dict()), said


def loop_margins(scenario: Scenario, law: LinearController | None) -> tuple[LoopMargins | None, list[str]]:
    """Margins of the law's loop (`ehamj.linear.margins`), worst of all places and of each motion; None without.

    Beside them what must be said: why there is no linear machine though the scenario has a place to rest, or that the
    loop is unstable.
    """
    if not feeds_back(law) and not any(used_options(one) for one in scenario.plant.actuators):
        return None, []
    try:
        model = linear_under(scenario.plant, law)
    except NotSmooth as error:
        return None, [str(error)]
    except InputError:
        if feeds_back(law):
            raise
        return None, []
    if law is None or not feeds_back(law):
        return None, []
    if closed := closed_at_rest(model):
        return None, [
            f"no margins: the valves of {', '.join(closed)} pass nothing more for a small command where they rest "
            "(overlap, hysteresis, threshold), so that the loop is open there; control.linearisation = true makes good "
            "what is known of them"
        ]
    margins = LoopMargins.model_validate(report(model, Loop.of(scenario, law)).to_dict(places=("motions",)))
    if margins.stable:
        return margins, []
    # An unstable loop has nothing in hand, however far its gain passes from −1.
    nothing = {"gain_db": 0.0, "phase_deg": 0.0, "disk": 0.0, "disk_all_valves": 0.0}
    return margins.changed(**nothing), [f"{UNSTABLE}: {margins.unstable.words}"] if margins.unstable else []
