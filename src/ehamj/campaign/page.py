"""The folder of a study of many designs: its page, tables and figures, and the best designs as scenarios."""

from pathlib import Path

from markupsafe import Markup

from ehamj.campaign.outcome import outcome_of
from ehamj.campaign.store import reading
from ehamj.campaign.studied import Studied
from ehamj.campaign.tables import CSV_FILE, PARQUET_FILE, export
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import SOURCES, Machine, source_of
from ehamj.pages import ANNEX, Page, Section
from ehamj.result import written_whole
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome
from ehamj.studies.page import files_of, headline_of, pictures_of, said_besides, tables_of, write_outcome

BEST = "best-{}.toml"
"""Scenario of one of the best designs, ready to be run."""


def write_study(folder: Path, name: str, studied: Studied, machine: Machine) -> Outcome:
    """Write all that people see of a study into its folder, which holds its store; what it came out with.

    Raises:
        OSError: if a file cannot be written.
    """
    outcome, scenarios = outcome_of(studied, source_notes(studied, machine)), best_scenarios(studied, machine, folder)
    export(folder)
    for old in folder.glob(BEST.format("*")):
        if old.name not in scenarios:
            old.unlink()
    for file, scenario in scenarios.items():
        with written_whole(folder / file) as path:
            path.write_text(scenario.to_toml(), encoding="utf-8")
    shown = page_of(outcome, studied, machine.scenario, list(scenarios))
    write_outcome(folder, name, outcome, machine.scenario, shown)
    return outcome


def source_notes(studied: Studied, machine: Machine) -> list[str]:
    """What must be known of the merits that a study asked for, by whatever computed them."""
    sources = dict.fromkeys(map(source_of, studied.merits))
    return [f"{name}: {note}" for name in sources for note in SOURCES[name].notes(machine)]


def best_scenarios(studied: Studied, machine: Machine, folder: Path) -> dict[str, Scenario]:
    """The best designs as scenarios, by the name of their file; their values are those of the folder's store."""
    found = {}
    with reading(folder) as store:
        for place, row in enumerate(studied.best, 1):
            number = int(studied.design(row)["number"])
            (design,) = store.rows(number, number + 1)
            said = f"design {number} of the study {studied.file.title!r}"
            found[BEST.format(place)] = scenario_of(machine, design.values).model_copy(
                update={"name": f"best-{place}", "description": said}
            )
    return found


def page_of(outcome: Outcome, studied: Studied, scenario: Scenario, scenarios: list[str]) -> Page:
    """Its page."""
    designs = f"{PARQUET_FILE} and {CSV_FILE} (all {len(studied.designs):,} designs)"
    files = Markup("{}").format(files_of(outcome, more=[designs, *scenarios]))
    again = Markup(". <code>ehamj study study.toml</code> does the study again, and comes out the same.")
    runs = Markup(" <code>ehamj run {}</code> simulates the best design.").format(scenarios[0]) if scenarios else ""
    tables = tables_of(outcome)
    sections = [
        *said_besides(outcome),
        Section("figures", figures=pictures_of(outcome)),
        Section("notes", "What holds, and what does not", items=outcome.notes),
        ANNEX,
        *([Section("tables", "Numbers", tables=tables)] if tables else []),
        Section("files", "Files", notes=[files + again + runs]),
    ]
    lead = f"{outcome.question} Machine: {scenario.name}."
    return Page(f"{outcome.title}: {scenario.name}", outcome.title, lead, sections, headline_of(outcome))
