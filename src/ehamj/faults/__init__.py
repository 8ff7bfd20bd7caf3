"""What fails in the course of a run: valves, seals, the supply, sensors; one file per kind."""

from ehamj.faults.fault import FaultSettings
from ehamj.faults.kinds import FAULTS, Fault, in_order

__all__ = ["FAULTS", "Fault", "FaultSettings", "in_order"]
