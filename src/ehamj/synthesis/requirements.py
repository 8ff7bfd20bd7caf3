"""What a law must hold, and on which machines."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from pydantic import Field

from ehamj.control.linearisation import Linearisation, made_good
from ehamj.control.spools import followed
from ehamj.plant.bodies import Inertia, tensor_of, written_inertia
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant
from ehamj.settings import Positive, Settings, Vector3

if TYPE_CHECKING:
    from ehamj.linear.machine import LinearModel

NOMINAL: Final = "as designed"
"""The machine that a law is designed for, among those that it must hold on."""


class Requirements(Settings):
    """Margins that practitioners ask for, at every place where the loop can be broken."""

    gain_margin: float = Field(6.0, ge=0, le=60, description="least gain margin [dB]")
    phase_margin: float = Field(45.0, ge=0, lt=90, description="least phase margin [deg]")
    disk_margin: float = Field(0.5, ge=0, lt=2, description="least disk margin, also of all valves at once [-]")

    def met_by(self, worst: tuple[float, float, float]) -> bool:
        """Whether gain [dB], phase [deg] and disk margin suffice."""
        return all(value >= least for value, least in zip(worst, self.asked, strict=True))

    @property
    def asked(self) -> tuple[float, float, float]:
        """Gain [dB], phase [deg] and disk margin."""
        return self.gain_margin, self.phase_margin, self.disk_margin


class Variations(Settings):
    """Machines that the same law must hold on, beside the one that it is designed for."""

    mass: tuple[Positive, ...] = Field((0.7, 1.3), description="factors on the machine's mass, with all that is on it")
    oil: tuple[Positive, ...] = Field((0.5,), description="factors on the oil's bulk modulus")
    flow: tuple[Positive, ...] = Field((1.5,), description="factors on the valves' flow gain")
    cg: tuple[float, ...] = Field((), description="sideways shifts of the centre of gravity along x and y [m]")
    all: tuple[Positive, ...] = Field(
        (0.95,),
        description="factors on mass, bulk modulus and flow gain at once: what the law believes wrongly; a design says "
        "what is left of the isolation there",
    )

    @property
    def wrong(self) -> tuple[str, ...]:
        """Names of the machines on which all is off at once."""
        return tuple(f"mass, oil and flow × {factor:g}" for factor in self.all)

    def plants(self, plant: Plant) -> Iterator[tuple[str, Plant]]:
        """The machine as it is, then each variation, with its name."""
        yield NOMINAL, plant
        for name, words in (("mass", "mass"), ("oil", "oil stiffness"), ("flow", "flow gain")):
            for factor in getattr(self, name):
                yield f"{words} × {factor:g}", with_factors(plant, **{name: factor})
        for shift in self.cg:
            yield f"centre of gravity off by {shift:g} m", _shifted(plant, shift)
        for name, factor in zip(self.wrong, self.all, strict=True):
            yield name, with_factors(plant, mass=factor, oil=factor, flow=factor)


def _shifted(plant: Plant, shift: float) -> Plant:
    """A plant whose machine, with all that is on it, stands off by a shift along x and y [m] on its mounts."""

    def off(place: Vector3) -> Vector3:
        x, y, z = place
        return (x + shift, y + shift, z)

    return replace(
        plant,
        machine=plant.machine.model_copy(update={"cg": off(plant.machine.cg)}),
        carrier=plant.carrier and plant.carrier.model_copy(update={"cg": off(plant.carrier.cg)}),
        slides=tuple(slide.model_copy(update={"position": off(slide.position)}) for slide in plant.slides),
    )


def with_factors(plant: Plant, mass: float = 1.0, oil: float = 1.0, flow: float = 1.0) -> Plant:
    """A plant whose masses (machine and all on it, and their inertia), oil stiffness and valves' flow gain are
    multiplied."""
    actuators = tuple(
        one.with_values({"bulk_modulus": oil * one.bulk_modulus, "flow_gain": flow * one.flow_gain})
        for one in plant.actuators
    )
    slides = tuple(
        one.model_copy(update={"mass": mass * one.mass, "inertia": one.inertia and _times(mass, one.inertia)})
        for one in plant.slides
    )
    machine, carrier = _heavier(plant.machine, mass), plant.carrier and _heavier(plant.carrier, mass)
    return replace(plant, actuators=actuators, slides=slides, machine=machine, carrier=carrier)


def _heavier(machine: Machine, by: float) -> Machine:
    return machine.model_copy(update={"mass": by * machine.mass, "inertia": _times(by, machine.inertia)})


def _times(factor: float, inertia: Inertia) -> Inertia:
    return written_inertia(factor * tensor_of(inertia))


Machines = Mapping[str, "LinearModel"]
"""The linear models of a machine, `NOMINAL`, and of its variations, by name."""


OUTSIDE: Final = Linearisation(pressure_drop=False, flow_curve=False, null_offset=0.0)
"""Without overlap, hysteresis and threshold."""


def behind(plant: Plant, known: Mapping[str, Any], outside: bool = False) -> Plant:
    """A plant behind what a law has of its valves (`SampledSettings.known`): their linearisation, and the loops about
    their spools. ``outside`` of what is left of overlap and play: a valve that rests within passes nothing, and for it
    no law could be found."""
    found = made_good(followed(plant, known["spools"]), known["valves"])
    return made_good(found, OUTSIDE.known(found)) if outside else found


def machines_of(
    plant: Plant, variations: Variations | None = None, known: Mapping[str, Any] | None = None, outside: bool = False
) -> dict[str, "LinearModel"]:
    """A plant and its variations, each linearised about its equilibrium, `behind` what a law has of its valves."""
    from ehamj.linear.machine import linear_model

    found = (variations or Variations()).plants(plant)
    return {name: linear_model(one if known is None else behind(one, known, outside)) for name, one in found}
