"""The command that finds parameters of a machine from measurements."""

from collections.abc import Sequence
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ehamj.cli.frame import Command, Json, Out, Overwrite, app, log
from ehamj.cli.printing import print_json, print_names, print_table, say
from ehamj.cli.progress import doing
from ehamj.errors import InputError
from ehamj.folders import check_out, new_folder
from ehamj.scenario_files import shipped_identifications, table_of

if TYPE_CHECKING:
    from ehamj.identification.outcome import Identification, Identified, TestFit


@app.command(cls=Command)
def identify(
    file: Annotated[
        str | None, typer.Argument(metavar="[FILE]", help="An identification file (TOML), or a shipped one's name.")
    ] = None,
    out_folder: Out = None,
    overwrite: Overwrite = False,
    threads: Annotated[
        int | None, typer.Option("--threads", metavar="N", help="Threads that step runs [default: one a core].")
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Override a key of the file, e.g. fit.starts=8."),
    ] = None,
    plan: Annotated[
        bool, typer.Option("--plan", help="Say which test to make next instead, and write what it takes to make it.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Find parameters of a machine from measurements of tests on it.

    The file says which machine, which of its values are looked for, and which tests tell them; without one, those that
    ship are listed. The folder holds identification.html (read it first), scenario.toml, the identified machine
    (`ehamj run` simulates it), identification.json with all numbers (values with their standard deviations and
    correlations, which of them the data cannot tell, how well each channel fits), identification.nc with what was
    measured beside what the model says, and robustness.toml, a study of machines as the data leave them open.

    With --plan nothing need have been measured. It predicts how well each test that could be made would tell each
    parameter (multisines at the valves, a hammer, a shaker, the floor as it is, the supply shut, loads that are held;
    or those of the file's table [plan]), and says which to make next. The folder holds plan.html (read it first),
    plan.json, the recommended tests as scenarios, their signals as CSV, and plan.toml, which identifies from them once
    they are measured.

    What an identification file may hold, `ehamj schema identify` says.
    """
    if file is None:
        if plan:
            raise InputError("--plan: which tests, an identification file says; name one, or one that ships")
        shipped = {name: _title(path) for name, path in shipped_identifications().items()}
        print_names("identifications", shipped, "title", as_json)
        return
    if threads is not None and threads < 1:
        raise InputError(f"--threads {threads}: must be at least 1")
    if plan:
        _planned(file, out_folder, overwrite, threads, overrides or (), as_json)
        return
    from ehamj.identification.identify import identify as found_by
    from ehamj.identification.saving import MARKS

    check_out(out_folder, overwrite, MARKS)
    with doing("identify", steps=True) as step:
        found = found_by(file, overrides=overrides or (), progress=step, threads=threads)
        step("writing")
        with new_folder(out_folder, overwrite) as place:
            found.save(place.target)
    if as_json:
        print_json({"folder": str(place.folder), **found.to_dict()})
        return
    print_found(found)
    say(f"the identified machine: {place.folder / 'scenario.toml'}", whole=True)
    say(f"page, numbers and figures: {place.folder / 'identification.html'}", whole=True)


def _title(path: Path) -> str:
    return str(table_of(path, "identification").get("title", ""))


def _planned(
    file: str, out_folder: Path | None, overwrite: bool, threads: int | None, overrides: Sequence[str], as_json: bool
) -> None:
    """Say which test to make next, and write what it takes to make it."""
    from ehamj.cli.plan_tables import print_plan
    from ehamj.identification.planning.asked import plan_tests
    from ehamj.identification.planning.saving import MARKS

    check_out(out_folder, overwrite, MARKS)
    with doing("plan", steps=True) as step:
        found = plan_tests(file, overrides=overrides, progress=step, threads=threads)
        step("writing")
        with new_folder(out_folder, overwrite) as place:
            found.save(place.target)
    if as_json:
        print_json({"folder": str(place.folder), **found.to_dict()})
        return
    print_plan(found)
    say(f"page, tests and signals: {place.folder / 'plan.html'}", whole=True)


def print_found(found: "Identification") -> None:
    """Print what was found."""
    from ehamj.campaign.names import short_names

    short = short_names(found.values)
    print_table(
        found.file.title,
        ["parameter", "value", "±", "unit", "start", "remark"],
        [_row(short[key], one) for key, one in found.values.items()],
    )
    for one in found.combinations:
        say(one.words, "the data cannot tell: ")
    _more_told(found, short)
    rows = [row for held, tests in ((False, found.tests), (True, found.validation)) for row in _fits(tests, held)]
    print_table("how well it fits", ["test", "channel", "fit [%]", "remark"], rows, whole=2)
    for note in found.notes:
        log.print(f"note: {note}", markup=False, highlight=False, soft_wrap=True)


def _more_told(found: "Identification", short: dict[str, str]) -> None:
    """Print which options the data justify, and profiles, where they were asked for."""
    if found.choice is not None:
        rows = [[name.replace("_", " "), one.words] for name, one in found.choice.verdicts.items()]
        print_table("options of the valve", ["option", "what the data say"], rows)
    if found.profiles:
        from ehamj.identification.profiles import interval

        rows = [
            [short[key], *("open" if end is None else f"{end:.6g}" for end in interval(one)), found.values[key].unit]
            for key, one in found.profiles.items()
        ]
        print_table("by profile likelihood, 95 %", ["parameter", "from", "to", "unit"], rows)


def _row(key: str, one: "Identified") -> list[str]:
    value = "" if one.value is None else f"{one.value:.6g}"
    deviation = "" if one.deviation is None else f"{one.deviation:.2g}"
    said = "the data cannot tell it" if one.value is None else one.why
    return [key, value, deviation, "-" if one.unit in ("", "1") else one.unit, f"{one.start:.6g}", said]


def _behind(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def _fits(tests: tuple["TestFit", ...], held: bool) -> list[list[str]]:
    rows = []
    for test in tests:
        for channel in test.channels:
            said = ["held out"] if held else []
            if channel.whiteness is not None and not channel.whiteness.white and not held:
                said.append("errors are not white")
            rows.append([test.name, channel.name, "" if isnan(channel.fit) else f"{channel.fit:.4g}", ", ".join(said)])
        rows += [
            [test.name, name, "", f"{one.value:.5g} ± {one.deviation:.2g}{_behind(one.unit)}"]
            for name, one in test.unknowns.items()
            if one.value is not None and one.deviation is not None
        ]
    return rows
