"""What a law is derived from: a machine on its isolators, and the instruments that measure it."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from ehamj.control.channels import UPSTREAM
from ehamj.control.sensors import Sensors
from ehamj.errors import did_you_mean
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import Isolator
from ehamj.isolator.supply import Supply
from ehamj.plant.bodies import Body
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import DEFAULT_MOUNTS, FEWEST, MOST, MOUNTS, UP, Mount
from ehamj.plant.part import Part, check_parts
from ehamj.plant.plant import Plant
from ehamj.plant.points import check_unique
from ehamj.plant.slide import Slide, check_slides
from ehamj.plant.statics import check_standing
from ehamj.scenario_files import scenario_path, scenario_table
from ehamj.settings import SCENARIO, Settings


class Installation(Settings):
    """A machine on its isolators with its instruments, standing somewhere: all that a law is derived from."""

    gravity: float = Field(9.80665, ge=0, description="gravitational acceleration, downwards [m/s²]")
    plates: Literal["sliding", "tied"] = Field(
        "sliding",
        description="plates on joints of their own, or as inertia of the stroke coordinates (faster); either way they "
        "move along their isolators' directions only: across, the cylinders guide them and carry their weight",
    )
    machine: Machine = Machine.stated()
    part: tuple[Part, ...] = Field((), description="rigid parts on the machine, which add to its mass and inertia")
    slide: tuple[Slide, ...] = Field((), description="heavy parts that move on the machine, and add to its mass")
    mount: tuple[Mount, ...] = Field(DEFAULT_MOUNTS, description="3 to 32 mounts of any names; without, four")
    actuators: dict[str, Isolator] = Field(
        default_factory=lambda: {"isolator": Isolator()}, description="actuators by name"
    )
    supply: Supply = Supply.stated()
    sensors: Sensors = Sensors.stated()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = tuple(mount.name for mount in self.mount)
        if not FEWEST <= len(names) <= MOST:
            raise ValueError(f"mount: there are {len(names)}, there must be {FEWEST} to {MOST}")
        check_unique("mount", self.mount)
        check_parts(self.part, self.machine)
        check_slides(self.slide, self.machine)
        half_x, half_y, high = self.machine.size[0] / 2, self.machine.size[1] / 2, self.machine.size[2]
        for mount in self.mount:
            x, y, z = mount.place
            if abs(x) > half_x or abs(y) > half_y or abs(z) > high:
                raise ValueError(
                    f"mount {mount.name}: position = {list(mount.position)} lies outside the machine, "
                    f"which covers ±{half_x:g} by ±{half_y:g} m, and ±{high:g} m in height (machine.size)"
                )
            if mount.actuator not in self.actuators:
                raise ValueError(
                    f"mount {mount.name}: actuator = {mount.actuator!r}: "
                    f"{did_you_mean(mount.actuator, self.actuators)}must be one of the tables "
                    f"[actuators.NAME]: {', '.join(self.actuators)}"
                )
        if self.sensors.upstream is not None:
            if UPSTREAM in names:
                raise ValueError(f"mount {UPSTREAM}: bears the name of the sensor upstream; name the mount otherwise")
            self.sensors.upstream.check(self.plant.mounts, self.plant.positions)
        check_standing(self.plant, gravity=False)
        if set(names) != set(MOUNTS) or any(mount.along != UP for mount in self.mount):
            return self
        at = {mount.name: mount.position for mount in self.mount}
        if not (min(at["front-left"][0], at["front-right"][0]) > max(at["rear-left"][0], at["rear-right"][0])):
            raise ValueError("mount positions: x of the front mounts must be larger than x of the rear mounts")
        if not (min(at["front-left"][1], at["rear-left"][1]) > max(at["front-right"][1], at["rear-right"][1])):
            raise ValueError("mount positions: y of the left mounts must be larger than y of the right mounts")
        return self

    @cached_property
    def _mounts(self) -> tuple[Mount, ...]:
        if {mount.name for mount in self.mount} != set(MOUNTS):
            return self.mount
        return tuple(sorted(self.mount, key=lambda mount: MOUNTS.index(mount.name)))

    @property
    def others(self) -> tuple[Body, ...]:
        """What stands on the machine and adds to [machine]: parts, and slides at their start."""
        return (*(part.body for part in self.part), *(slide.body(slide.begins) for slide in self.slide))

    @property
    def where_slides_stand(self) -> tuple[str, ...]:
        """What a reader of a law, of modes and of other linear figures must know of slides that move."""
        moving = [f"{slide.name} at {slide.begins:g} m" for slide in self.slide if slide.moves]
        said = f"slides move: laws, modes and linear figures are those of the machine with {', '.join(moving)}"
        return (said,) if moving else ()

    @property
    def running(self) -> dict[str, Actuator]:
        """The actuators with the values that they run with, which is what is to be shown of them."""
        return {name: actuator.running_on(self.supply) for name, actuator in self.actuators.items()}

    @cached_property
    def plant(self) -> Plant:
        """The physical part, mounts in order."""
        return self._standing()

    def _standing(self) -> Plant:
        return Plant(
            machine=self.machine.with_bodies(self.others),
            positions=tuple(mount.place for mount in self._mounts),
            directions=tuple(mount.along for mount in self._mounts),
            heights=tuple(mount.height for mount in self._mounts),
            actuators=tuple(self.actuators[mount.actuator].rated_at(self.supply) for mount in self._mounts),
            supply=self.supply,
            gravity=self.gravity,
            mounts=tuple(mount.name for mount in self._mounts),
            plates=self.plates,
            slides=self.slide,
            carrier=self.machine.with_bodies([part.body for part in self.part]) if self.slide else None,
        )

    @property
    def installation(self) -> "Installation":
        """The machine alone, of whatever has one: what another law may be `DesignedFor`."""
        return Installation.model_construct(**{name: getattr(self, name) for name in PARTS})


PARTS: Final = tuple(Installation.model_fields)
"""Tables and values of a scenario that a law is derived from."""


def _read(source: Any) -> Any:
    """The machine of a scenario that is named or whose file is; anything else as it is."""
    if not isinstance(source, str):
        if source is None or isinstance(source, Installation | Mapping):
            return source
        raise ValueError("must be a table, or the name or file of a scenario")
    table = scenario_table(scenario_path(source))
    return Installation.model_validate({name: value for name, value in table.items() if name in PARTS})


DesignedFor = Annotated[
    Installation | None, SCENARIO, BeforeValidator(_read, json_schema_input_type=Installation | str | None)
]
"""The machine that a law is held for: a table of what differs from the scenario's own, or another scenario's name or
file. It is read once, and stored whole."""
