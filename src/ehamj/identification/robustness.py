"""A study of what the remaining uncertainty does: machines as the data leave them open, with their correlations."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import tomli_w

from ehamj.campaign.keys import own_value
from ehamj.control.settings import DigitalSettings

if TYPE_CHECKING:
    from ehamj.identification.outcome import Identification

NUMBER: Final = 500
"""Machines of the study."""
LEAST: Final = 0.05
"""Magnitude below which a correlation is not worth a line [-]."""
OPEN_LOOP: Final = ("passive.frequency.heave", "passive.frequency.yaw")
CLOSED_LOOP: Final = ("loop.stable", "loop.disk_margin", "loop.gain_margin")


def robustness(found: "Identification", scenario: str) -> str | None:
    """A study file, as ``ehamj study`` takes it, beside the identified ``scenario``, a file; None where no value has
    a deviation."""
    keys = list(_varied(found))
    if not keys:
        return None
    closed = isinstance(found.scenario.control, DigitalSettings)
    table: dict[str, Any] = {
        "title": f"{found.file.title}: what is left open",
        "question": "What does the machine do within what the measurements leave open of it?",
        "scenario": scenario,
        "law": "held",
        "merits": [*OPEN_LOOP, *(CLOSED_LOOP if closed else ())],
        "vary": {key: _spread(found, key) for key in keys},
        "plan": {"kind": "monte-carlo", "number": NUMBER},
    }
    pairs = list(_correlations(found, keys))
    if pairs:
        table["correlation"] = pairs
    return tomli_w.dumps(table)


def _varied(found: "Identification") -> Iterator[str]:
    """Keys that have a value and a deviation; lists have no spread of their own."""
    for key, one in found.values.items():
        if one.value is not None and one.deviation and not isinstance(own_value(found.scenario, key), list):
            yield key


def _spread(found: "Identification", key: str) -> dict[str, float]:
    one = found.values[key]
    low, high = one.bounds
    return {"mean": float(one.value or 0.0), "deviation": float(one.deviation or 0.0), "low": low, "high": high}


def _correlations(found: "Identification", keys: list[str]) -> Iterator[dict[str, Any]]:
    """Those that matter, all a little smaller where they would otherwise contradict each other by rounding."""
    order = list(found.values)
    own = found.correlation[np.ix_([order.index(key) for key in keys], [order.index(key) for key in keys])]
    kept = np.where(np.abs(own) >= LEAST, own, 0.0)
    np.fill_diagonal(kept, 1.0)
    least = float(np.linalg.eigvalsh(kept)[0])
    share = 1.0 if least > 1e-6 else (1.0 - 1e-6) / (1.0 - least)
    for i in range(len(keys)):
        for j in range(i):
            if kept[i, j]:
                yield {"between": [keys[j], keys[i]], "coefficient": float(f"{0.999999 * share * kept[i, j]:.6g}")}
