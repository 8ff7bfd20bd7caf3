"""Several runs on one page: what each is, and in which settings they differ."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from ehamj.control.settings import DigitalSettings
from ehamj.judge.actuation import DIRECTIONS
from ehamj.pages import Section, Table
from ehamj.pages.words import DASH, exact, plain
from ehamj.report.sections.inputs import named
from ehamj.report.shown import Shown, ground_parts
from ehamj.result import Result
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import named as named_differences
from ehamj.scenario.variation import unlike
from ehamj.settings import PROVENANCE

ASIDE: Final = ("name", "description", "compare", "output", *PROVENANCE, "designed_for")
"""Settings that say what a run is called, what is written of it and where its values come from, not what it does; and
the machine that a law is for, which has a line of its own."""
MOST: Final = 4
"""Settings of a table that only some runs have which are still told one by one."""
MISSING: Final = object()
UNIT: Final = re.compile(r"\[([^\]]*)\]")


def runs(shown: Shown) -> Section | None:
    """A line for each run, and a table of the settings that are not the same in all; None of a single run."""
    if shown.alone:
        return None
    return Section("runs", "What is compared", tables=[_each(shown), differences(shown)])


def runs_first(shown: Shown) -> Section | None:
    """The same in front, where what is compared is not a scenario and its variants."""
    return None if shown.together else runs(shown)


def runs_beside(shown: Shown) -> Section | None:
    """The same of a scenario and its variants."""
    return runs(shown) if shown.together else None


def _each(shown: Shown) -> Table:
    """Name, description, duration, floor, control and verdict of each run."""
    columns = []
    known = {name for result in shown.results.values() for name in result.summary.directions}
    judged = [name for name in DIRECTIONS if name in known]
    for result in shown.results.values():
        scenario, simulated = result.scenario, result.summary.timing.simulated_s
        cut = "" if result.complete else f" of {exact(scenario.duration)} s, incomplete"
        columns.append(
            {
                "what it is": scenario.description or DASH,
                "simulated": f"{exact(round(simulated, 6))} s{cut}",
                "floor": floor_in_words(scenario),
                "control": control_in_words(scenario),
                **{f"verdict, {name}": verdict_in_words(result, name) for name in judged},
                "judged by": result.summary.judged_by() or DASH,
            }
        )
    rows = [[name, *(column[name] for column in columns)] for name in columns[0]]
    note = "Verdict: the vibration class of the machine at its worst place."
    return Table("Runs", ["", *shown.results], rows, note, kind="words")


def verdict_in_words(result: Result, direction: str) -> str:
    """The machine's class along a direction; where something failed, of each part of the run by itself."""
    summary = result.summary
    found = {when: phase.criterion.briefly().get(direction, DASH) for when, phase in summary.parts().items()}
    if not found:
        said = summary.criterion.briefly().get(direction, DASH)
        return f"{summary.mixed}: {said}" if summary.mixed else said
    found |= dict.fromkeys(summary.unsettled(), "not settled")
    return ". ".join(f"{when}: {said}" for when, said in found.items())


def differences(shown: Shown) -> Table:
    """Every setting that is not the same in all runs, side by side; without rows where all are."""
    scenarios = [result.scenario for result in shown.results.values()]
    rows = [row for row in _differing(scenarios, "", "") if len(set(row[1:])) > 1]
    made = [derived_for(scenario) for scenario in scenarios]
    if len(set(made)) > 1:
        rows.append([named("control.designed_for", "machine that the law is derived for"), *made])
    bare = any(set(type(one.control).model_fields) - set(ASIDE) == {"kind"} for one in scenarios)
    mixed = bare and len({one.control.kind for one in scenarios}) > 1
    law = " but those of the law that are as by default, beside a run without one," if mixed else ""
    note = f"All other settings{law} are the same. {DASH}: the run has no such setting."
    return Table("Differences in settings", ["setting", *shown.results], rows, note, kind="words")


def derived_for(scenario: Scenario) -> str:
    """The machine that a scenario's law is derived for: its own, or what of it was otherwise."""
    if not isinstance(scenario.control, DigitalSettings):
        return DASH
    other = unlike(scenario.nominal, scenario.installation)
    return named_differences(other, "{key} = {one}") if other else "the run's own"


def floor_in_words(scenario: Scenario) -> str:
    """Kinds of the ground, each with what tells it from others of its kind."""
    return " + ".join(_kind_in_words(part) for part in ground_parts(scenario))


def control_in_words(scenario: Scenario) -> str:
    """Kind of the control, and the parts that it is the sum of."""
    return _kind_in_words(scenario.control)


def _kind_in_words(settings: Any) -> str:
    """The kind of some settings, with a name, level or file that they are by, and their parts."""
    found = [str(getattr(settings, "kind", type(settings).__name__))]
    for name in ("name", "level", "file", "floor"):
        value = getattr(settings, name, None)
        if isinstance(value, str) and value:
            found.append(value)
    parts = getattr(settings, "parts", ())
    return " ".join(found) + (f" ({', '.join(_kind_in_words(part) for part in parts)})" if parts else "")


def _differing(values: Sequence[Any], key: str, about: str) -> Iterator[list[str]]:
    """Rows of what differs in some values: name and key, and each as text; tables are gone through, one that a run does
    not have as one without settings.

    Of a law beside a control that has no settings those are told that are not as by default.
    """
    if all(value == values[0] for value in values[1:]):
        return
    tables = [{} if value is MISSING or value is None or value == () else _table(value) for value in values]
    whole = [table for table in tables if table is not None]
    if len(whole) < len(tables) or not any(whole):
        yield [named(key, _short(about)), *(_in_words(value, about) for value in values)]
        return
    names = dict.fromkeys(name for table in whole for name in table)
    bare = key == "control" and any(set(table) - set(ASIDE) == {"kind"} for table in whole)
    for name in sorted(names, key=lambda one: one != "kind"):
        found = [table.get(name, ABSENT) for table in whole]
        told = not bare or name == "kind" or any(one is not ABSENT and one.value != one.default for one in found)
        if name not in ASIDE and told:
            text = next((one.about for one in found if one.about), about)
            yield from _differing([one.value for one in found], f"{key}.{name}".lstrip("."), text)


class Part(NamedTuple):
    """A setting of a table."""

    value: Any
    about: str = ""
    default: Any = MISSING


ABSENT: Final = Part(MISSING)


def _table(value: Any) -> dict[str, Part] | None:
    """The settings of a table by name; None of a value that has none."""
    if isinstance(value, BaseModel):
        fields = type(value).model_fields.items()
        return {name: Part(getattr(value, name), _about(f), f.get_default()) for name, f in fields}
    if isinstance(value, Mapping):
        return {str(name): Part(part) for name, part in value.items()}
    if isinstance(value, tuple) and value and all(isinstance(part, BaseModel) for part in value):
        names = [getattr(part, "name", None) for part in value]
        return {
            n if isinstance(n, str) and n else str(k): Part(p)
            for k, (n, p) in enumerate(zip(names, value, strict=True))
        }
    return None


def _short(about: str) -> str:
    """A description without its explanations, with its unit."""
    unit = UNIT.search(about)
    said = re.split(r"[:;(\[]", about)[0].strip()
    return f"{said} {unit.group()}" if unit else said


def _about(field: FieldInfo) -> str:
    """What a setting is, with its unit."""
    said, extra = field.description or "", field.json_schema_extra
    unit = extra.get("unit") if isinstance(extra, dict) else None
    return f"{said} [{unit}]" if unit and UNIT.search(said) is None else said


def _in_words(value: Any, about: str = "") -> str:
    """A setting as text: of a table its kind, or what was set of it, each with its unit."""
    if value is MISSING:
        return DASH
    table = _table(value)
    if table is None:
        return plain(value)
    if isinstance(value, tuple):
        return ", ".join(_in_words(part) for part in value)
    if isinstance(value, BaseModel) and hasattr(value, "kind"):
        return _kind_in_words(value)
    given = value.model_fields_set if isinstance(value, BaseModel) else set(table)
    told = {name: part for name, part in table.items() if name in given and name not in ASIDE}
    if len(told) > MOST:
        return f"{len(told)} settings"
    said = (f"{name} {_in_words(part.value)}{_unit(part.about or about)}" for name, part in told.items())
    return ", ".join(said) or "as it is by default"


def _unit(about: str) -> str:
    """The unit in a description, to follow a number."""
    unit = UNIT.search(about)
    return "" if unit is None or unit.group(1) == "-" else f" {unit.group(1)}"
