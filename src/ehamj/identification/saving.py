"""What an identification leaves in its folder."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ehamj.identification.profiles import interval
from ehamj.result import written_whole

if TYPE_CHECKING:
    from ehamj.identification.outcome import Identification, Identified, TestFit

SCENARIO_FILE: Final = "scenario.toml"
NUMBERS_FILE: Final = "identification.json"
HISTORIES_FILE: Final = "identification.nc"
STUDY_FILE: Final = "robustness.toml"
PAGE_FILE: Final = "identification.html"
MARKS: Final = (NUMBERS_FILE,)
"""Files without which a folder is none of an identification."""


def save(found: "Identification", folder: Path) -> None:
    """Write the identified scenario, the numbers, what was measured beside what is predicted, a study of what is left
    open, and the page with its figures, into a folder that is there.

    Raises:
        OSError: if a file cannot be written.
    """
    from ehamj.identification.histories import write_histories
    from ehamj.identification.page import page_of
    from ehamj.identification.robustness import robustness
    from ehamj.pages import write_page

    _write(folder / SCENARIO_FILE, found.scenario.to_toml())
    _write(folder / NUMBERS_FILE, json.dumps(to_dict(found), indent=2, allow_nan=False) + "\n")
    with written_whole(folder / HISTORIES_FILE) as path:
        write_histories(found, path)
    study = robustness(found, SCENARIO_FILE)
    if study is not None:
        _write(folder / STUDY_FILE, study)
    write_page(folder, PAGE_FILE, page_of(found, study is not None))


def _write(place: Path, text: str) -> None:
    with written_whole(place) as path:
        path.write_text(text, encoding="utf-8")


def to_dict(found: "Identification") -> dict[str, Any]:
    """Numbers of an identification, as JSON has them."""
    return {
        "title": found.file.title,
        "values": {key: _value(one) for key, one in found.values.items()},
        "correlation": finite(found.correlation),
        "cannot_tell": [
            {"parameters": list(one.parameters), "vector": finite(one.vector), "words": one.words}
            for one in found.combinations
        ],
        "tests": [_test(one) for one in found.tests],
        "validation": [_test(one) for one in found.validation],
        "cost": finite(found.cost),
        "samples": found.samples,
        "notes": list(found.notes),
        "fit": finite(dict(found.told)),
        "profiles": {
            key: {"values": finite(one[:, 0]), "rise": finite(one[:, 1]), "interval_95": list(interval(one))}
            for key, one in found.profiles.items()
        },
        **({} if found.choice is None else {"choice": found.choice.to_dict()}),
    }


def _value(one: "Identified") -> dict[str, Any]:
    return {
        "value": one.value, "deviation": finite(one.deviation), "unit": one.unit, "start": one.start,
        "bounds": finite(list(one.bounds)), "at_bound": one.at_bound, "status": one.status, "why": one.why,
    }  # fmt: skip


def _test(one: "TestFit") -> dict[str, Any]:
    channels = [
        {
            "name": channel.name, "unit": channel.unit, "axis": channel.axis, "samples": len(channel.at),
            "fit_percent": finite(channel.fit), "deviation_rms": finite(float(np.sqrt(np.mean(channel.deviation**2)))),
            "white": None if channel.whiteness is None else channel.whiteness.white,
        }
        for channel in one.channels
    ]  # fmt: skip
    own = {name: _value(value) for name, value in one.unknowns.items()}
    return {"name": one.name, "kind": one.kind, "channels": channels, "unknowns": own, "found": finite(one.found)}


def finite(value: Any) -> Any:
    """Arrays as lists, and what is no number as null."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return finite(value.tolist())
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if isinstance(value, np.generic):
        return finite(value.item())
    if isinstance(value, complex):
        return [finite(value.real), finite(value.imag)]
    return None if isinstance(value, float) and not np.isfinite(value) else value
