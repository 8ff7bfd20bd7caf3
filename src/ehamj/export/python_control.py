"""Plant and law as JSON whose systems have the arguments of python-control's ``control.ss``."""

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from ehamj.export.subject import Subject
from ehamj.export.systems import (
    ABOUT,
    System,
    laws_of,
    parts_of,
    plants_of,
    rest_of,
    seen_by,
    settings_of,
    what_to_know,
)
from ehamj.export.written import Written

LOAD: Final = "s = json.load(open('{path}'))['plant']; plant = control.ss(*[s.pop(k) for k in 'ABCD'], **s)"


def write_python_control(subject: Subject, path: Path) -> Written:
    """Write objects ``plant``, ``plant_sampled`` and ``law``, each the arguments of ``control.ss``; of a law of several
    rates lists, ``law[k]`` beside the plant as it sees it."""
    plants, systems = plants_of(subject), {"plant_sampled": seen_by(subject), "law": laws_of(subject)}
    parts, notes = parts_of(subject), what_to_know(subject)
    content: dict[str, Any] = {
        "ehamj": version("ehamj"),
        "scenario": subject.scenario.name,
        "toml": subject.scenario.to_toml(),
        "load": LOAD.replace("{path}", path.name),
        "notes": list(notes),
        "about": ABOUT,
        **{name: _arguments(one) for name, one in plants.items()},
        "units": {name: one.units for name, one in plants.items()},
        "scales": {name: one.scales.tolist() for name, one in plants.items()},
        "operating_point": {name: rest_of(subject, one) for name, one in plants.items()},
    }
    if parts:
        content |= {name: _single([_arguments(one) for one in some]) for name, some in systems.items()}
        content["units"] |= {name: _single([one.units for one in some]) for name, some in systems.items()}
        content["law_settings"] = _single([settings_of(part) for part in parts])
    path.write_text(json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8")
    return Written({path.name: f"plant and law for python-control: {LOAD}"}, notes)


def _arguments(system: System) -> dict[str, Any]:
    """A system as the arguments of ``control.ss``."""
    matrices = {name: matrix.tolist() for name, matrix in zip("ABCD", system.matrices, strict=True)}
    names = {"inputs": list(system.inputs), "outputs": list(system.outputs), "states": list(system.states)}
    return {**matrices, "dt": system.dt, **names, "name": system.name}


def _single(some: list[Any]) -> Any:
    return some[0] if len(some) == 1 else some
