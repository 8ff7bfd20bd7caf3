"""The whole nonlinear machine with every hydraulic option, integrated by SciPy: an independent model.

It shares its input with `ehamj.run` (parameters, ground, commands, control law) and no equation: the rigid body
has kinematics to second order in its angles, written as matrices; SciPy's Runge–Kutta with error control
takes it from sample to sample of the controller; play between spool and metering edges and the spool's end stops are
modes whose ends are found as roots. The right-hand side is compiled for speed only.
"""

from ehamj.verify.reference.run import ReferenceRun, simulate_reference

__all__ = ["ReferenceRun", "simulate_reference"]
