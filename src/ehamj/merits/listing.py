"""Figures of merit as a list that a person reads: names that differ by an axis, a band or a place in one line."""

from collections.abc import Mapping

from ehamj.criteria.vc import CLASSES
from ehamj.designs.many import RIGID_MODES
from ehamj.errors import InputError
from ehamj.estimate.statistics import WORDS
from ehamj.judge.levels import BANDS
from ehamj.merits.merit import Merit
from ehamj.plant.axes import AXES, DOFS
from ehamj.scenario.model import Scenario


def listing(merits: Mapping[str, Merit], scenario: Scenario, find: str = "") -> dict[str, Merit]:
    """Merits by name, or by what stands for several names, the first of which tells what they are.

    Args:
        merits: all of a scenario, by name.
        scenario: whose mounts, actuators and points are places.
        find: what must be in a name; those that have it are listed each by itself.

    Raises:
        InputError: if no name has it.
    """
    if find:
        found = {name: one for name, one in merits.items() if find in name}
        if not found:
            raise InputError(f"--find {find!r}: is in no name of a merit; without it all kinds are listed")
        return found
    words = _words(scenario)
    kinds: dict[str, Merit] = {}
    for name, one in merits.items():
        kinds.setdefault(_kind(name, words), one)
    return kinds


def _words(scenario: Scenario) -> dict[str, str]:
    """What stands for each word of a name that is one of many."""
    mounts = scenario.plant.mounts
    found = dict.fromkeys((*AXES, *DOFS), "AXIS")
    found |= {name.replace(" ", "-"): "MODE" for name in (*RIGID_MODES, *scenario.plant.central.patterns)}
    found |= dict.fromkeys(WORDS.keys() - {"rms", "peak"}, "STATISTIC")  # which are said of other things too
    found |= {name.replace(" ", "-"): "CLASS" for name in CLASSES}
    found |= dict.fromkeys((*mounts, *(f"valve-{mount}" for mount in mounts)), "MOUNT")
    return found | dict.fromkeys(scenario.points, "POINT") | dict.fromkeys(scenario.actuators, "ACTUATOR")


def _kind(name: str, words: Mapping[str, str]) -> str:
    """A name with what stands for its words; a band may have a point in its number."""
    for band in sorted((band.name for band in BANDS), key=len, reverse=True):
        if name.endswith(f".{band}"):
            name = f"{name.removesuffix(band)}BAND"
            break
    parts = [words.get(part, part) for part in name.split(".")]
    return ".".join("READING" if part.startswith("reading-") else part for part in parts)
