"""The benchmark case in Exudyn, a C++ multibody code with a hydraulic actuator: the best peer that was found.

A rigid body on Cartesian spring-dampers; the actuator with its valves shut gives force and swept volume; spool and
flows of the valve, which it does not have, come from a user function that Exudyn turns into an expression of its own.
The rotations of the body are Tait–Bryan angles: the node with a rotation vector loses increments below 1e-8 rad and
still reports success, and motions here are 1e-7 rad.
"""

from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.bench.ceiling import System
from ehamj.scenario.model import Scenario

REACH: Final = 0.5
"""Offset and stroke of an actuator, whose sum is its length [m]: some length, since all act along z."""
CHANNELS: Final = 4
"""Of an isolator: both pressures, spool, its rate."""


class ExudynCase:
    """The benchmark in Exudyn with explicit Runge–Kutta steps of fourth order [s]; a call takes them."""

    def __init__(self, exudyn: Any, scenario: Scenario, step: float) -> None:
        from exudyn import itemInterface  # type: ignore[import-not-found]

        exudyn.SetWriteToConsole(False)  # it warns of every user function
        self._exudyn, self._items, self._scenario = exudyn, itemInterface, scenario
        self._system = System.of(scenario, step)
        self._container = exudyn.SystemContainer()  # what it holds lives as long as it does
        self._mbs = self._container.AddSystem()
        self._kept: list[Any] = []
        ground = self._mbs.AddObject(itemInterface.ObjectGround())
        self._body_node, body = self._body()
        self._pressures = [self._isolator(mount, ground, body) for mount in range(self._system.table.size)]
        self._sensors = [self._sensor(node) for node in (self._body_node, *self._pressures)]
        self._mbs.Assemble()
        self._settings = self._fastest(step)

    def __call__(self) -> None:
        """Take the steps."""
        solver = self._exudyn.DynamicSolverType.RK44
        if not self._mbs.SolveDynamic(self._settings, solverType=solver):
            raise RuntimeError("Exudyn did not reach the end of the benchmark")

    def channels(self) -> Array:
        """As `ehamj.bench.ceiling.Ceiling.channels` gives them."""
        self()
        body, *pressures = (np.asarray(self._mbs.GetSensorStoredData(sensor))[:, 1:] for sensor in self._sensors)
        height, (rx, ry) = self._scenario.plant.machine.cg[2], body[:, 3:5].T
        motion = [body[:, 0] - height * ry, body[:, 1] + height * rx, body[:, 2], rx, ry]
        return np.column_stack([*motion, *(both[:, 0] - both[:, 1] for both in pressures)])

    def _body(self) -> tuple[Any, Any]:
        items, machine = self._items, self._scenario.plant.machine
        node = self._mbs.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=[*machine.cg, 0.0, 0.0, 0.0]))
        tensor = machine.tensor
        inertia = [tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        return node, self._mbs.AddObject(items.ObjectRigidBody(nodeNumber=node, mass=machine.mass, inertia=inertia))

    def _isolator(self, mount: int, ground: Any, body: Any) -> Any:
        """Add a mount; its node of two pressures."""
        items, mbs, row, cg = self._items, self._mbs, self._system.table[mount], self._scenario.plant.machine.cg
        at = np.array(self._scenario.plant.positions[mount])

        def marker(number: Any, place: Array) -> Any:
            return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=number, localPosition=list(place)))

        def states(start: float) -> Any:
            start_and_zero: dict[str, Any] = {"referenceCoordinates": [0.0, 0.0], "initialCoordinates": [start, start]}
            return mbs.AddNode(items.NodeGenericODE1(numberOfODE1Coordinates=2, **start_and_zero))

        foot, beside = marker(body, at - cg), marker(ground, at)
        below = marker(ground, at - [0.0, 0.0, 2 * REACH])
        lateral, axial = float(row["lateral_stiffness"]), float(row["membrane_stiffness"])
        dampings = [float(row["lateral_damping"])] * 2 + [float(row["membrane_damping"])]
        springs = {"stiffness": [lateral, lateral, axial], "damping": dampings}
        mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=[beside, foot], **springs))
        pressures = states(0.5 * (row["supply_pressure"] + row["tank_pressure"]))
        spool = states(0.0)
        mbs.AddObject(
            items.ObjectConnectorHydraulicActuatorSimple(
                markerNumbers=[below, foot], nodeNumbers=[pressures], offsetLength=REACH, strokeLength=REACH,
                chamberCrossSection0=row["piston_area"], chamberCrossSection1=row["piston_area"],
                hoseVolume0=row["volume_1"], hoseVolume1=row["volume_2"], oilBulkModulus=row["bulk_modulus"],
                nominalFlow=row["flow_gain"], systemPressure=row["supply_pressure"], tankPressure=row["tank_pressure"],
            )
        )  # fmt: skip
        valve = mbs.AddObject(items.ObjectGenericODE1(nodeNumbers=[pressures, spool]))
        self._set_rates(valve, mount)
        return pressures

    def _set_rates(self, valve: Any, mount: int) -> None:
        """Let a symbolic user function give the rates of both pressures by flow, and of the spool."""
        symbolic = self._exudyn.symbolic
        time, number, q = (
            symbolic.Real("t", 0.0),
            symbolic.Real("itemNumber", 0),
            symbolic.Vector("q", [0.0] * CHANNELS),
        )
        before = symbolic.GetRecording()
        symbolic.SetRecording(True)
        rates = symbolic.Vector(self._rates(symbolic, mount, time, q))
        symbolic.SetRecording(before)
        function = symbolic.UserFunction()
        said = {
            "functionName": "rates", "argList": [self._mbs, time, number, q],
            "argTypeList": ["MainSystem", "Real", "Index", "StdVector"],
            "returnValue": rates,
            "returnType": "StdVector",
        }  # fmt: skip
        function.SetUserFunctionFromDict(self._mbs, said, "rhsUserFunction", valve, "None")
        self._mbs.SetObjectParameter(valve, "rhsUserFunction", function)
        self._kept.append((function, time, number, q, rates))  # Exudyn does not keep them

    def _rates(self, symbolic: Any, mount: int, time: Any, q: Any) -> list[Any]:
        row = {name: float(self._system.table[mount][name]) for name in self._system.table.dtype.names}
        supply, tank, natural = row["supply_pressure"], row["tank_pressure"], row["valve_frequency"]
        one, two, spool, rate = (q[k] for k in range(CHANNELS))
        feeds = 0.5 * symbolic.sign(spool) + 0.5

        def through(drop: Any) -> Any:
            root = symbolic.sqrt(symbolic.abs(drop) * (1.0 / row["rated_pressure"]))
            return row["flow_gain"] * spool * symbolic.sign(drop) * root

        leak = row["cross_leakage"] * (one - two)
        into_1 = through(feeds * (supply - one) + (1.0 - feeds) * (one - tank)) - leak
        into_2 = leak - through(feeds * (two - tank) + (1.0 - feeds) * (supply - two))
        command = float(self._system.amplitude[mount]) * symbolic.sin(float(self._system.angular[mount]) * time)
        drive = natural * natural * (row["valve_gain"] * command - spool)
        moduli = [row["bulk_modulus"] / row[volume] for volume in ("volume_1", "volume_2")]
        damped = drive - 2.0 * row["valve_damping"] * natural * rate
        return [moduli[0] * into_1, moduli[1] * into_2, rate, damped]

    def _sensor(self, node: Any) -> Any:
        kind = self._exudyn.OutputVariableType.Coordinates
        kept = {"storeInternal": True, "writeToFile": False}
        return self._mbs.AddSensor(self._items.SensorNode(nodeNumber=node, outputVariableType=kind, **kept))

    def _fastest(self, step: float) -> Any:
        """Settings with which it is fastest: nothing is computed, written or shown that the rows do not need."""
        settings = self._exudyn.SimulationSettings()
        own, explicit = settings.timeIntegration, settings.timeIntegration.explicit
        own.numberOfSteps, own.endTime, own.verboseMode = self._system.steps, self._system.steps * step, 0
        explicit.computeEndOfStepAccelerations = explicit.eliminateConstraints = explicit.useLieGroupIntegration = False
        explicit.computeMassMatrixInversePerBody = True
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = self._system.every * step
        return settings
