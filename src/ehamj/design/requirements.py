"""What a design must hold, and on which machines."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from ehamj.control.linearisation import made_good
from ehamj.control.settings import SampledSettings
from ehamj.control.spools import followed
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario
from ehamj.settings import Positive, Settings, Vector3


class Requirements(Settings):
    """Margins that practitioners ask for, at every place where the loop can be broken."""

    gain_margin: Annotated[float, Field(ge=0)] = Field(6.0, description="least gain margin [dB]")
    phase_margin: Annotated[float, Field(ge=0, lt=90)] = Field(45.0, description="least phase margin [deg]")
    disk_margin: Annotated[float, Field(ge=0, lt=2)] = Field(
        0.5, description="least disk margin, all valves at once [-]"
    )


class Variations(Settings):
    """Machines that the same law must hold on, each changed in one respect from the one it is designed for."""

    mass: tuple[Positive, ...] = Field((0.7, 1.3), description="factors on the machine's mass")
    oil: tuple[Positive, ...] = Field((0.5,), description="factors on the oil's bulk modulus")
    flow: tuple[Positive, ...] = Field((1.5,), description="factors on the valves' flow gain")
    cg: tuple[float, ...] = Field((), description="sideways shifts of the centre of gravity along x and y [m]")

    def scenarios(self, scenario: Scenario) -> dict[str, Scenario]:
        """The machine as it is, then each variation, by name."""
        found = {"as designed": scenario}
        for name, words in (("mass", "mass"), ("oil", "oil stiffness"), ("flow", "flow gain")):
            for factor in getattr(self, name):
                found[f"{words} × {factor:g}"] = with_factors(scenario, **{name: factor})
        for shift in self.cg:
            found[f"centre of gravity off by {shift:g} m"] = _shifted(scenario, shift)
        return found


def _shifted(scenario: Scenario, shift: float) -> Scenario:
    """A scenario whose machine, with all that is on it, stands off by a shift along x and y [m] on its mounts."""

    def off(place: Vector3) -> Vector3:
        x, y, z = place
        return (x + shift, y + shift, z)

    machine = scenario.machine.with_values({"cg": off(scenario.machine.cg)})
    others = {
        key: tuple(one.model_copy(update={"position": off(one.position)}) for one in getattr(scenario, key))
        for key in ("part", "slide")
    }
    return scenario.model_copy(update={"machine": machine, **others})


def with_factors(scenario: Scenario, mass: float = 1.0, oil: float = 1.0, flow: float = 1.0) -> Scenario:
    """A scenario whose masses (machine and all on it), oil stiffness and valves' flow gain are multiplied."""
    actuators = {
        name: actuator.with_values(
            {"bulk_modulus": oil * actuator.bulk_modulus, "flow_gain": flow * actuator.flow_gain}
            | ({"rated_flow": flow * actuator.rated_flow} if actuator.rated_flow else {})
        )
        for name, actuator in scenario.actuators.items()
    }
    machine = scenario.machine.with_values({"mass": mass * scenario.machine.mass})
    others = {
        key: tuple(one.model_copy(update={"mass": mass * one.mass}) for one in getattr(scenario, key))
        for key in ("part", "slide")
    }
    return scenario.model_copy(update={"actuators": actuators, "machine": machine, **others})


Machines = Mapping[str, LinearModel]
"""The linear models of a machine, "as designed", and of its variations, by name."""


def machines_of(scenario: Scenario, variations: Variations | None = None) -> Machines:
    """The machine and its variations, each linearised about its equilibrium, its valves as the law has them."""
    return {name: linear_model(behind(one)) for name, one in (variations or Variations()).scenarios(scenario).items()}


def behind(scenario: Scenario) -> Plant:
    """The plant behind what a scenario's law is to have of its valves: their linearisation, and the loops about their
    spools."""
    control = scenario.control
    if not isinstance(control, SampledSettings):
        return scenario.plant
    designed = scenario.as_designed()
    known = control.known(designed.plant, designed.sensors)
    return made_good(followed(scenario.plant, known["spools"]), known["valves"])
