"""The kinds of fault there are, and the faults of a scenario in the order in which they strike."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ehamj.faults.chamber_leak import ChamberLeak
from ehamj.faults.fault import FaultSettings
from ehamj.faults.sensor_dead import SensorDead
from ehamj.faults.sensor_gain import SensorGain
from ehamj.faults.spool_drift import SpoolDrift
from ehamj.faults.supply_lost import SupplyLost
from ehamj.faults.valve_stuck import ValveStuck
from ehamj.settings import one_of

FAULTS: tuple[type[FaultSettings], ...] = (
    ValveStuck,
    SpoolDrift,
    ChamberLeak,
    SupplyLost,
    SensorDead,
    SensorGain,
)
"""Every kind of fault; a table [[fault]] holds one of them."""

if TYPE_CHECKING:
    Fault = FaultSettings
else:
    Fault = one_of(FAULTS)


def check_faults(faults: Sequence[FaultSettings], mounts: Sequence[str], duration: float) -> None:
    """Refuse faults at places that do not exist, after the end, or beside others that they do not add up with.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    for k, fault in enumerate(faults):
        if fault.time >= duration:
            raise ValueError(f"fault.{k}.time = {fault.time:g} s must be before the end, duration = {duration:g} s")
        try:
            fault.check(mounts)
            for other in (*faults[:k], *faults[k + 1 :]):
                fault.check_beside(other)
        except ValueError as error:
            raise ValueError(f"fault.{k}.{error}") from None


def in_order(faults: Sequence[FaultSettings]) -> tuple[FaultSettings, ...]:
    """As they strike; of those at one time, as they are written."""
    return tuple(sorted(faults, key=lambda fault: fault.time))
