"""What a plan leaves in its folder: page and numbers, and what it takes to make the tests and to identify from them."""

import csv
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import tomli_w

from ehamj.identification.planning.instruments import unit_of_channel
from ehamj.identification.planning.page import outcome_of, page_of
from ehamj.identification.planning.trial import Trial
from ehamj.pages import safe_name, write_page
from ehamj.result import written_whole
from ehamj.scenario.model import Scenario

if TYPE_CHECKING:
    from ehamj.identification.planning.outcome import Forecast, Plan

NUMBERS_FILE: Final = "plan.json"
MACHINE_FILE: Final = "scenario.toml"
FILE: Final = "plan.toml"
"""The identification file for what the tests will have measured."""
MARKS: Final = (NUMBERS_FILE, FILE)
"""Files without which a folder is none of a plan."""
MEASURED: Final = "-measured.csv"
"""How the names end of files that a logger is to write."""


def save(plan: "Plan", folder: Path) -> None:
    """Write the plan; see `ehamj.identification.planning.outcome.Plan.save`."""
    outcome = outcome_of(plan)
    _write_text(folder / MACHINE_FILE, plan.machine.to_toml())
    _write_text(folder / FILE, tomli_w.dumps(identification_file(plan)))
    files = [MACHINE_FILE, f"{FILE} (identifies from the tests, once they are made)", NUMBERS_FILE]
    for trial in (one.trial for one in made(plan)):
        stem = safe_name(trial.name)
        if trial.course != "rest":
            _write_text(folder / f"{stem}.toml", trial.scenario.to_toml())
            files.append(f"{stem}.toml (the test as a scenario)")
        if trial.played:
            write_signals(folder / f"{stem}.csv", trial, plan.instruments.rate)
            files.append(f"{stem}.csv (what is played)")
    write_page(folder, "plan.html", page_of(plan, outcome, f"Files beside this page: {', '.join(files)}"), figures=".")
    _write_text(folder / NUMBERS_FILE, json.dumps(plan.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def made(plan: "Plan") -> "list[Forecast]":
    """Tests of the sequence, each once."""
    return list({step.forecast.trial.name: step.forecast for step in plan.sequence}.values())


def identification_file(plan: "Plan") -> dict[str, Any]:
    """An identification file that takes what the recommended tests will have measured, one file each."""
    parameters = {
        one.name: {"bounds": [one.low, one.high]}
        | ({} if one.prior is None else {"prior": {"mean": one.prior.mean, "deviation": one.prior.deviation}})
        for one in plan.unknowns
    }
    tests = [_test(plan, forecast) for forecast in made(plan) if forecast.trial.course != "rest"]
    own = plan.settings.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    asked = {"plan": own} if own else {}
    return {"title": plan.title, "scenario": MACHINE_FILE, "parameters": parameters, "test": tests, **asked}


def _test(plan: "Plan", forecast: "Forecast") -> dict[str, Any]:
    """A table [[test]]; what no test counts on is free in it, as in the prediction."""
    trial = forecast.trial
    outputs: dict[str, dict[str, Any]] = {}
    for name in forecast.moving:
        outputs[name] = {"channel": name, "unit": unit_of_channel(name), "offset": "free"}
        outputs[name] |= dict.fromkeys(plan.settings.free, "free")
        if trial.course in ("nonlinear", "decaying"):  # it comes to rest, and stays
            outputs[name]["accept"] = ["clipped"]
    inputs = {name: dict(one) for name, one in trial.inputs.items()}
    return {
        "name": trial.name,
        "kind": "record",
        "file": safe_name(trial.name) + MEASURED,
        "settle": trial.settle,
        "rate": plan.instruments.rate,
        "set": _held_still(plan.machine, trial) | dict(trial.otherwise),
        "measurement": inputs | outputs,
    }


def _held_still(machine: Scenario, trial: Trial) -> dict[str, Any]:
    """What of the machine does not act in a test, where it is not measured: its law, its floor, forces and faults."""
    found: dict[str, Any] = {"control": {"kind": "passive"}, "ground": {"kind": "rest"}}
    found |= {name: [] for name in ("force", "fault") if getattr(machine, name)}
    if any(name.startswith("ground_") for name in trial.inputs):
        del found["ground"]
    return found


def write_signals(path: Path, trial: Trial, rate: float) -> None:
    """What is played, over the whole test, as a converter takes it: time and a column for each signal, units in the
    heads."""
    time = np.arange(round(trial.scenario.duration * rate)) / rate
    columns = [one.signal().sample(time).value for one in trial.played.values()]
    units = ["N" if name == "force" else "V" for name in trial.played]
    head = ["time [s]", *(f"{name} [{unit}]" for name, unit in zip(trial.played, units, strict=True))]
    with written_whole(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        rows = zip(time, *columns, strict=True)
        writer.writerows([f"{values[0]:.9g}", *(f"{value:.6g}" for value in values[1:])] for values in rows)


def _write_text(path: Path, text: str) -> None:
    with written_whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
