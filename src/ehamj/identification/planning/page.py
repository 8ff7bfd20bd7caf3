"""A plan as a person reads it: answers, tables, a figure, a page."""

from typing import TYPE_CHECKING, Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.campaign.names import short_names
from ehamj.identification.planning.candidate import rounded
from ehamj.identification.planning.information import TOLD
from ehamj.pages import ANNEX, Page, Section, Table
from ehamj.pages.words import DASH
from ehamj.plots import Figure
from ehamj.plots.effects import Effects, effects_chart
from ehamj.studies.outcome import Drawing, Outcome
from ehamj.studies.page import headline_of, pictures_of, said_besides

if TYPE_CHECKING:
    from ehamj.identification.planning.outcome import Forecast, Plan

CAUTION: Final = (
    "Noise is all that predicted deviations count: a gain that nobody calibrated ([plan] free) and what the model "
    "leaves out come on top."
)
NOTES: Final = (
    "Deviations are those that no unbiased fit of such a test goes below (Cramér and Rao), at the values that the "
    "sensitivities are taken at; a machine that is another than believed comes out otherwise.",
    CAUTION,
    "Tests are predicted by the linear model about rest, where one has none by the small-motion engine; those that are "
    "recommended by the engine as well.",
    "Before any test a parameter counts as known as its prior says, or as any value within its bounds.",
    f"A test is said to tell a parameter that it sharpens at least {TOLD:g} times.",
    "Loggers are taken to filter before they sample. One that does not sees a blow of 5 ms at 1000 Hz 3 % too weak, "
    "and masses and stiffnesses come out as much too low.",
    "The ground's motion below 0.25 Hz is not had from a record of its velocity or acceleration: where the floor is "
    "all that drives, strokes and pressures tell, and absolute velocities less than is predicted.",
)


def outcome_of(plan: "Plan") -> Outcome:
    """The plan as an outcome, as studies and designs have it."""
    return Outcome(
        title=plan.title,
        question=f"Which test next, to know {len(plan.keys)} parameters of {plan.machine.name} better?",
        answers=plan.answers,
        tables=tables_of(plan),
        drawings=drawings_of(plan),
        notes=(*NOTES, *(f"{name}: cannot be predicted: {why}" for name, why in plan.refused.items())),
        numbers=plan.to_dict(),
    )


def tables_of(plan: "Plan") -> dict[str, xr.Dataset]:
    """Predicted deviations and factors, (test, parameter); and along the sequence."""
    units = ("parameter", [one.unit or "1" for one in plan.unknowns], {"long_name": "unit of the parameter"})
    keys = ("parameter", list(plan.keys), {"long_name": "parameter"})
    alone = _dataset(
        "What each candidate would tell, made alone", keys, units, [one.trial.name for one in plan.forecasts],
        np.array([one.deviations for one in plan.forecasts]), plan.before,
    )  # fmt: skip
    names = [f"{k}: {step.forecast.trial.name}" for k, step in enumerate(plan.sequence, 1)]
    after = np.array([step.deviations for step in plan.sequence])
    found = {"candidates": alone} if plan.forecasts else {}
    if plan.sequence:
        found["sequence"] = _dataset(
            "After each test of the recommended sequence", keys, units, names, after, plan.before
        )
    return found


def _dataset(title: str, keys: object, units: object, tests: list[str], deviations: Array, before: Array) -> xr.Dataset:
    of = ("test", "parameter")
    values = {
        "deviation": (
            of,
            deviations,
            {"long_name": "predicted standard deviation in the parameter's unit", "units": "1"},
        ),
        "factor": (of, before / deviations, {"long_name": "sharpened by the factor", "units": "1"}),
    }
    coordinates = {"test": ("test", tests, {"long_name": "test"}), "parameter": keys, "unit": units}
    return xr.Dataset(values, coordinates, {"title": title})


def drawings_of(plan: "Plan") -> dict[str, Drawing]:
    """How much sharper each parameter would become."""
    if not plan.forecasts:
        return {}

    def draw() -> Figure:
        best = np.array([one.factors for one in plan.forecasts]).max(axis=0)
        sets = [Effects("by the best test for it alone", np.log10(best))]
        if plan.sequence:
            sets.append(Effects("by the recommended tests", np.log10(plan.before / plan.sequence[-1].deviations)))
        title = f"What tests would tell: {plan.machine.name}"
        return effects_chart(title, "sharpened by [decades]", plan.keys, sets, 0.0, "as before")

    caption = (
        "By how many powers of ten each parameter's standard deviation would become smaller: by the one test that is "
        "best for it, and by the recommended tests together."
    )
    return {"sharpened": Drawing(caption, draw)}


def candidate_table(plan: "Plan") -> Table:
    """What each test alone would tell of each parameter: deviation and, behind ×, how many times sharper that is; a
    dash where it does not tell it. Tests that tell the same stand in one row."""
    names = zip(short_names(plan.keys).values(), _units(plan), strict=True)
    head = ["test, made alone", *(f"{short.replace('_', ' ')} [{unit}]" for short, unit in names)]
    table = [[name, *shown(one)] for name, one in told_apart(plan)]
    note = "± predicted standard deviation, × by which factor smaller it is than before."
    return Table("What each test would tell", head, table, note, kind="words")


def told_apart(plan: "Plan") -> list[tuple[str, "Forecast"]]:
    """Tests by name, those that tell the same once."""
    found: dict[tuple[str, ...], list[Forecast]] = {}
    for one in plan.forecasts:
        found.setdefault((one.trial.kind, *shown(one)), []).append(one)
    return [(some[0].trial.name + _alike(len(some) - 1), some[0]) for some in found.values()]


def shown(one: "Forecast") -> list[str]:
    """Deviations and factors as a person reads them."""
    pairs = zip(one.deviations, one.factors, strict=True)
    return [DASH if factor < TOLD else f"±{deviation:.2g} ×{rounded(factor):g}" for deviation, factor in pairs]


def _alike(others: int) -> str:
    return f" ({others} more alike)" if others else ""


def _units(plan: "Plan") -> list[str]:
    return ["-" if one.unit in ("", "1") else one.unit for one in plan.unknowns]


def deviation_table(plan: "Plan") -> Table:
    """Parameters with their deviations before, after each test of the sequence, and by the nonlinear engine."""
    steps = plan.sequence
    head = ["parameter", "value", "unit", "before", *(f"test {k}" for k in range(1, len(steps) + 1))]
    last = steps[-1].nonlinear if steps else None
    head += ["by engine"] if last is not None else []
    rows = []
    for k, (one, short) in enumerate(zip(plan.unknowns, short_names(plan.keys).values(), strict=True)):
        row = [short, f"{plan.at[one.name]:.5g}", _units(plan)[k], f"{plan.before[k]:.2g}"]
        row += [f"{step.deviations[k]:.2g}" for step in steps]
        rows.append(row + ([f"{last[k]:.2g}"] if last is not None else []))
    numeric = [k for k in range(len(head)) if k not in (0, 2)]
    title = "Predicted standard deviations before and after each recommended test"
    note = "by engine: after the last one, by the nonlinear engine" if last is not None else ""
    return Table(title, head, rows, note, kind="words", numeric=numeric)


def page_of(plan: "Plan", outcome: Outcome, files: str) -> Page:
    """The page; ``files`` says what stands beside it."""
    tests = [f"{one.trial.name}: {one.trial.words}" for one in plan.forecasts]
    channels = [(name, plan.instruments.told(name)) for name in plan.instruments.channels]
    sections = [
        *said_besides(outcome),
        Section("tables", tables=[deviation_table(plan), candidate_table(plan)]),
        Section("figures", figures=pictures_of(outcome)),
        Section("notes", "What holds, and what does not", items=outcome.notes),
        ANNEX,
        Section("candidates", "The candidates", items=tests),
        Section("instruments", "Channels and their noise", facts=channels),
        Section("files", "Files", notes=[files]),
    ]
    return Page(f"{plan.title}: which test next", "Which test next", outcome.question, sections, headline_of(outcome))
