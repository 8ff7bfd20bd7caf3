"""Ground motion: displacement, velocity and acceleration of every mount in three axes, consistent with each other."""

from ehamj.ground.motion import GroundSample, Motion, Slab, Start

__all__ = ["GroundSample", "Motion", "Slab", "Start"]
