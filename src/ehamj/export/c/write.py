"""Write a law as a folder of C99."""

from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from ehamj.control import LinearController, PythonController
from ehamj.control.loop import DigitalLoop, make_loop
from ehamj.errors import InputError
from ehamj.export.c import tables, text
from ehamj.export.c.ticks import Clock, clock_of, fade_of
from ehamj.export.c.vectors import Vectors, ticks_for, vectors
from ehamj.scenario.model import Scenario

FUNCTIONS = ("laws", "lines", "opening", "learning", "stage", "spools", "step")
"""Parts of the C that compute."""
PAGES = ("ehamj_law.h", "ehamj_law.c", "main.c", "Makefile", "README.txt")


@cache
def _environment() -> Environment:
    loader = PackageLoader("ehamj.export.c")
    made = Environment(
        loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    made.filters |= {"number": text.number, "comment": text.comment, "beside": text.beside}
    made.globals["zip"] = zip
    return made


def _sources() -> str:
    """The functions of the C, as their templates have them."""
    loader = _environment().loader
    assert loader is not None
    return "".join(loader.get_source(_environment(), f"{part}.c")[0] for part in FUNCTIONS)


def write_law(scenario: Scenario, controller: Any, timestep: float, name: str, folder: Path) -> tuple[Clock, Vectors]:
    """Write a scenario's law into a folder that is there; returns its clock, and what its vectors hold.

    Args:
        scenario: whose machine and sensors it runs with.
        controller: the law; None of none.
        timestep: of a run [s].
        name: of the whole.
        folder: where to.

    Raises:
        InputError: if there is no law, or one that C cannot have; if the scenario cannot be run.
    """
    law = _exportable(controller, scenario)
    loop = make_loop(law, scenario.plant, timestep, scenario.sensors, scenario.seed)
    clock = clock_of(loop.laws, timestep)
    found = vectors(scenario, law, clock, ticks_for(scenario, law, clock))
    filled = tables.shortened(_filled(law, loop, clock, name), _sources())
    filled["vectors"] = _said(found, clock)
    # By what tells it, a file notices that it is handed the headers of two laws.
    filled["told_by"] = f"0x{crc32(_environment().get_template('ehamj_law.c').render(filled).encode()):08x}"
    for page in PAGES:
        made = _environment().get_template(page).render(filled)
        (folder / page).write_text(made, encoding="utf-8")
    _write_vectors(folder / "vectors.csv", law, found)
    return clock, found


def _exportable(controller: Any, scenario: Scenario) -> LinearController:
    """The law, if it is one that C can have."""
    if isinstance(controller, PythonController):
        raise InputError("--c: the law is a Python function, which is not exported; only laws made of matrices are")
    if controller is None:
        raise InputError(
            f"--c: scenario {scenario.name!r} has no law, control.kind = {scenario.control.kind!r}; choose one that "
            "has, such as --set 'control={kind=\"combined\"}', or leave out --c"
        )
    own: LinearController = controller
    if not own.reads:
        raise InputError("--c: the law reads no channel, so that there is nothing to hand it; name its inputs")
    return own


def _filled(law: LinearController, loop: DigitalLoop, clock: Clock, name: str) -> dict[str, Any]:
    """What the templates are filled with."""
    own = law.converter
    parts = law.parts
    entries, matrices = tables.laws_of(parts, loop)
    lines, pairs = tables.lines_of(loop)
    staged, spools = tables.stage_of(loop), tables.spools_of(loop, len(parts))
    rested = [k for k, rest in enumerate(loop.sensing.zeroed) if rest]
    sizes = {
        "states": max(sum(part.states for part in parts), 1),
        "largest": max(*(part.states for part in parts), 1),
        "inputs": max(*(len(part.inputs) for part in parts), 1),
        "places": max(clock.places, 1),
        "pairs": pairs,
    }
    kept = (*(one.name for one in matrices), "LAW", "ROW", *_kept(lines, staged, spools))
    return {
        "title": f"{name}: its control law",
        "made": f"Written by ehamj {version('ehamj')}.",
        "clock": clock,
        "limit": text.number(own.voltage_limit),
        "resolution": text.number(own.resolution),
        "readings": tables.readings_of(law, loop),
        "valves": tables.valves_of(law),
        "laws": entries,
        "tables": matrices,
        "table_sizes": [f"sizeof({one})" for one in kept],
        "rows": clock.rows,
        "sizes": sizes,
        "fade": fade_of(own.switch_on, own.fade, clock),
        "counted_from_rest": rested,
        "ranges": [min(float(volts), own.voltage_limit) for volts in loop.laws.ranges],
        "contents": _contents(law, lines, staged, spools),
        **lines,
        **staged,
        **spools,
    }


def _kept(lines: dict[str, Any], staged: dict[str, Any], spools: dict[str, Any]) -> list[str]:
    """Names of the tables beside those of the laws."""
    found = ["LINE", "LINE_AT"] if lines["lines"] else []
    found += ["KNOWN", "MOVES", "CURVE"] if staged["staged"] else []
    found += ["PRESSURE"] if staged["pressures"] else []
    found += ["LEARNER", "PACED", "STROKE"] if staged["learns"] else []
    found += ["SPOOL", "PACES", "POSITION"] if spools["fed"] else []
    return [*found, *(["RANGE"] if spools["fed"] or staged["learns"] else [])]


def _contents(
    law: LinearController, lines: dict[str, Any], staged: dict[str, Any], spools: dict[str, Any]
) -> list[str]:
    """What is in the law, in words."""
    states = f"{law.states} states" if len(law.parts) == 1 else f"{len(law.parts)} laws of {law.states} states"
    found = [states, *(["anti-windup"] if any(part.anti_windup is not None for part in law.parts) else [])]
    found += [f"{len(lines['lines'])} lines that are followed"] if lines["lines"] else []
    found += ["what of the valves is made good"] if staged["staged"] else []
    found += ["learning"] if staged["learns"] else []
    found += ["loops about the spools"] if spools["fed"] else []
    found += ["fade"] if law.converter.switch_on or law.converter.fade else []
    return [*found, "range and rounding"]


def _said(found: Vectors, clock: Clock) -> str:
    """What the vectors hold, one line."""
    seconds = len(found.readings) * clock.period
    return f"readings and commands of the first {seconds:g} s of a run, {len(found.readings)} ticks"


def _write_vectors(path: Path, law: LinearController, found: Vectors) -> None:
    """One row per tick: readings [SI], then commands before range and rounding [V]; each number is the very one."""
    names = (*law.reads, *law.converter.outputs)
    with path.open("w", encoding="utf-8") as file:
        file.write("# " + ",".join(names) + "\n")
        for row in np.hstack([found.readings, found.volts]).tolist():
            file.write(",".join(map(repr, row)) + "\n")
