"""The page of an identification: what the data tell and how well, what they cannot, and how the model fits them."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from markupsafe import Markup

from ehamj.campaign.names import short_names
from ehamj.identification.figures import drawings_of_test, fit_words, off, reading, size_of, value_drawings
from ehamj.identification.modes_shown import mode_tables
from ehamj.identification.profiles import interval
from ehamj.pages import ANNEX, Page, Picture, Section, Table, badge
from ehamj.pages.words import DASH, exact, number, within
from ehamj.report.sections.inputs import named
from ehamj.studies.outcome import Drawing

if TYPE_CHECKING:
    from ehamj.identification.outcome import ChannelFit, Identification, Identified, TestFit

LONGEST: Final = 40
"""Samples of a channel without an order that a table shows."""
STATUS: Final = {"identified": "identified", "unidentifiable": "not told", "prior": "known before"}
LOOK: Final = {"identified": "identified", "unidentifiable": "assumed", "prior": "known"}
"""Badge of each status."""


def page_of(found: "Identification", studied: bool) -> Page:
    """The page.

    Args:
        found: the identification.
        studied: whether a study of what is left open stands beside it.
    """
    sections = [
        *_warnings(found),
        Section(
            "values",
            "What the data tell",
            list(_pictures(value_drawings(found))),
            [values_table(found), *profile_table(found)],
        ),
        *_untold(found),
        *_choice(found),
        Section("fit", "How well the model fits", tables=[fit_table(found)], notes=[FIT]),
        *(_test(test, "") for test in found.tests),
        *(_test(test, ", held out") for test in found.validation),
        ANNEX,
        Section("how", "How it was found", facts=list(_facts(found))),
        Section("files", "Files", notes=[files_words(studied)]),
    ]
    lead = f"{len(found.values)} values of {found.scenario.name}, from {_counted(len(found.tests), 'test')}."
    return Page(f"{found.file.title}: {found.scenario.name}", found.file.title, lead, sections, list(verdict(found)),
                list(_alerts(found)))  # fmt: skip


FIT: Final = (
    "Fit: 100 % less what is left over what the channel does about its mean. White: what is left has no order in it "
    "that a model could still explain (Ljung and Box, 1 %)."
)


def verdict(found: "Identification") -> Iterator[tuple[str, str]]:
    """What came out, in two sentences."""
    names = short_names(found.values)
    told = {key: one for key, one in found.values.items() if one.value is not None}
    spreads = {key: 100.0 * one.deviation / size_of(one) for key, one in told.items() if one.deviation is not None}
    said = f"{len(told)} of {_counted(len(found.values), 'value')} told by the data"
    if spreads:
        best, least = min(spreads, key=spreads.__getitem__), max(spreads, key=spreads.__getitem__)
        said += f", the best to {number(spreads[best], 2)} % ({names[best]})"
        if best != least:
            said += f", the least to {number(spreads[least], 2)} % ({names[least]})"
    yield "", said + "."
    lost = [names[key] for key in found.values if key not in told]
    if lost:
        yield "", f"Not told by these data, and without a number: {', '.join(lost)}."


def _alerts(found: "Identification") -> Iterator[tuple[str, str]]:
    if found.told.get("converged") is False:
        yield (
            "Not converged.",
            "The fit stopped before it came to its end: values and deviations are not the last word.",
        )


def _warnings(found: "Identification") -> Iterator[Section]:
    if found.notes:
        yield Section("warnings", items=found.notes, items_title="To be known", kind="warnings")


def values_table(found: "Identification") -> Table:
    """Every value beside its start."""
    names = short_names(found.values)
    rows = []
    for key, one in found.values.items():
        change = DASH if one.value is None else number(off(one, one.value), 2)
        rows.append([named(key, names[key]), value_words(one), one.unit, exact(float(f"{one.start:.6g}")), change,
                     bounds_words(one), status_words(one)])  # fmt: skip
    head = ("quantity", "value ± deviation", "unit", "start", "change [%]", "bounds", "status")
    return Table("Values", head, rows, kind="words", numeric=(1, 3, 4, 5))


def profile_table(found: "Identification") -> Iterator[Table]:
    """95 % intervals by profile likelihood, where they were asked for."""
    names, rows = short_names(found.values), []
    for key, one in found.profiles.items():
        ends = ["open" if end is None else number(end, 4) for end in interval(one)]
        rows.append([named(key, names[key]), *ends, found.values[key].unit])
    if rows:
        head = ("quantity", "from", "to", "unit")
        yield Table("95 % by profile likelihood, all others fitted again", head, rows, kind="words", numeric=(1, 2))


def value_words(one: "Identified") -> str:
    """A value with its deviation."""
    if one.value is None:
        return DASH
    return number(one.value, 4) if one.deviation is None else within(one.value, one.deviation)


def bounds_words(one: "Identified") -> str:
    """The bounds of a value; those that there are not are left open."""
    low, high = (number(end, 3) if np.isfinite(end) else DASH for end in one.bounds)
    return f"{low} to {high}"


def status_words(one: "Identified") -> str:
    """Whether the data tell it, and what is to be said of it."""
    at = (
        badge(f"at its {one.at_bound} bound", "assumed")
        if one.at_bound
        else badge(STATUS[one.status], LOOK[one.status])
    )
    return at if not one.why or one.at_bound else at + " " + one.why


def _untold(found: "Identification") -> Iterator[Section]:
    lost = [one.words for one in found.combinations]
    if lost:
        note = (
            "Along these directions the model predicts the same within the noise. A prior, or a test that moves them "
            "apart (ehamj identify FILE --plan), tells them."
        )
        yield Section("cannot-tell", "What the data cannot tell", items=lost, notes=[note])


def _choice(found: "Identification") -> Iterator[Section]:
    if found.choice is None:
        return
    about = found.choice.to_dict()
    rows = []
    for name, one in about["options"].items():
        kind = (
            ("justified", "identified") if one["justified"] else ("not needed" if one["told"] else "not told", "plain")
        )
        rows.append([name.replace("_", " "), badge(*kind), one["words"]])
    table = Table("Options of the valve", ("option", "", "why"), rows, kind="words")
    criterion = {"bic": "BIC", "aicc": "AICc"}[about["criterion"]]
    note = f"Decided by {criterion}: what an option explains must be worth its parameters."
    yield Section("choice", "Which options of the valve the data justify", tables=[table], notes=[note])


def fit_table(found: "Identification") -> Table:
    """Every channel of every test: fit, noise, whiteness."""
    rows = [
        [test.name + held, *_fit_row(one)]
        for tests, held in ((found.tests, ""), (found.validation, " (held out)"))
        for test in tests
        for one in test.channels
    ]
    head = ("test", "channel", "fit [%]", "noise", "left, RMS", "unit", "samples", "white")
    best = [one.fit for test in found.tests for one in test.channels if np.isfinite(one.fit)]
    folded = (
        f"{len(rows)} channels, fit {number(min(best))} to {number(max(best))} %"
        if len(rows) > LONGEST and best
        else ""
    )
    return Table("Channels", head, rows, kind="words", numeric=(2, 3, 4, 6), folded=folded)


def _fit_row(one: "ChannelFit") -> list[str]:
    factor, unit = reading(one.unit)
    left = factor * float(np.sqrt(np.mean(np.abs(one.measured - one.predicted) ** 2)))
    noise = factor * float(np.sqrt(np.mean(one.deviation**2)))
    white = DASH if one.whiteness is None else "yes" if one.whiteness.white else "no"
    return [one.name, number(one.fit), number(noise), number(left), unit, str(len(one.at)), white]


def _test(test: "TestFit", held: str) -> Section:
    tables = [*mode_tables(test.found), *_number_tables(test), *_unknowns(test)]
    return Section(f"test-{test.name}".replace(" ", "-"), f"Test {test.name}: {test.kind}{held}",
                   list(_pictures(drawings_of_test(test, bool(held)))), tables,
                   [text] if (text := str(test.found.get("method", ""))) else [])  # fmt: skip


def _pictures(drawings: Iterable[tuple[str, Drawing]]) -> Iterator[Picture]:
    for name, one in drawings:
        yield Picture(name, one.draw(), one.caption)


def _number_tables(test: "TestFit") -> Iterator[Table]:
    """Channels without an order beside each other; modes have tables of their own."""
    for one in test.channels:
        if one.axis != "number" or "after" in test.found or len(one.at) > LONGEST or np.iscomplexobj(one.measured):
            continue
        factor, unit = reading(one.unit)
        columns = (factor * np.asarray(values, float) for values in (one.measured, one.predicted, one.deviation))
        rows = [[str(k), *map(number, row)] for k, row in enumerate(zip(*columns, strict=True), 1)]
        title = f"{one.name} [{unit}]{', ' if (fit := fit_words(one)) else ''}{fit}"
        yield Table(title, ("reading", "measured", "model", "deviation"), rows)


def _unknowns(test: "TestFit") -> Iterator[Table]:
    """Offsets, gains and delays of its own."""
    rows = [[name, value_words(one), one.unit] for name, one in test.unknowns.items()]
    if rows:
        yield Table(
            "Its own unknowns", ("of the measurement", "value ± deviation", "unit"), rows, kind="words", numeric=(1,)
        )


def _facts(found: "Identification") -> Iterator[tuple[str, str]]:
    yield "data", f"{found.samples:,} numbers of {_counted(sum(len(one.channels) for one in found.tests), 'channel')}"
    yield "engine", found.file.engine
    for key in ("starts", "steps", "runs"):
        if key in found.told:
            yield key, f"{found.told[key]:,}"
    if "seconds" in found.told:
        yield "time", f"{number(float(found.told['seconds']))} s"
    yield "−2·log likelihood", number(found.cost, 7)


def files_words(studied: bool) -> str:
    """What stands beside the page, and what it is for."""
    said = Markup(
        "Beside this page: scenario.toml, the identified machine, each value with its source and deviation "
        "(<code>ehamj run scenario.toml</code>); identification.nc, what was measured and what the model predicts, a "
        "group for each test; identification.json, all numbers; figures/."
    )
    if not studied:
        return said
    return said + Markup(
        " robustness.toml draws machines from what the data leave open, with their correlations: "
        "<code>ehamj study robustness.toml</code>."
    )


def _counted(many: int, what: str) -> str:
    return f"{many} {what}{'' if many == 1 else 's'}"
