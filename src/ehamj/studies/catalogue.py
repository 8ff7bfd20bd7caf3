"""The studies that `ehamj study` runs, by name."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from ehamj.errors import InputError
from ehamj.scenario.model import Scenario
from ehamj.studies.failed import FailedStudy, failed_actuator
from ehamj.studies.gains import GainStudy, loop_gains
from ehamj.studies.lateral import LateralStudy, lateral_stiffness
from ehamj.studies.levels import LevelStudy, levels
from ehamj.studies.outcome import Outcome, Progress
from ehamj.studies.rocking import RockingStudy, rocking
from ehamj.studies.soft_mounts import SoftMountStudy, soft_mounts
from ehamj.studies.unequal import UnequalStudy, unequal_loads
from ehamj.studies.valve_oil import ValveOilStudy, valve_and_oil
from ehamj.studies.waves import WaveStudy, waves


@dataclass(frozen=True)
class Study:
    """A question about a machine, and how it is answered with the study's default settings."""

    question: str
    run: Callable[[Scenario, Progress], Outcome]


STUDIES: Final[dict[str, Study]] = {
    "rocking": Study(
        "sway and rocking over CG height and footprint: 2,601 designs, and where soft mounts let them tip",
        lambda scenario, progress: rocking(RockingStudy(scenario), progress),
    ),
    "lateral": Study(
        "what the lateral stiffness of the mounts does to sway, rocking and yaw",
        lambda scenario, progress: lateral_stiffness(LateralStudy(scenario), progress),
    ),
    "unequal-loads": Study(
        "a centre of gravity beside the middle: loads of the mounts, heave that rocks",
        lambda scenario, progress: unequal_loads(UnequalStudy(scenario), progress),
    ),
    "valve-and-oil": Study(
        "what valve and oil do to the modes, and to the fastest loop",
        lambda scenario, progress: valve_and_oil(ValveOilStudy(scenario), progress),
    ),
    "gains": Study(
        "root locus of the whole machine over the gain of its law, and its limit",
        lambda scenario, progress: loop_gains(GainStudy(scenario), progress),
    ),
    "failed-actuator": Study(
        "one actuator failed (stuck valve, leak, no oil): modes, forces, what isolation is left",
        lambda scenario, progress: failed_actuator(FailedStudy(scenario), progress),
    ),
    "levels": Study(
        "attenuation against the floor's level, from VC-E to workshop: what the valves are enough for",
        lambda scenario, progress: levels(LevelStudy(scenario), progress),
    ),
    "soft-mounts": Study(
        "elastic and pneumatic mounts as the baseline, and when the machine tips over on them",
        lambda scenario, progress: soft_mounts(SoftMountStudy(scenario), progress),
    ),
    "waves": Study(
        "which travelling wave in the floor rocks the machine most",
        lambda scenario, progress: waves(WaveStudy(scenario), progress),
    ),
}


def study(name: str) -> Study:
    """A study by its name.

    Raises:
        InputError: if there is none.
    """
    if name not in STUDIES:
        raise InputError(f"study {name!r}: must be one of {', '.join(STUDIES)}")
    return STUDIES[name]
