"""The one table of memory: records of isolators, of their states, of a step's inputs and results, of load and supply.

Everything that must agree between the model, the compiled callbacks, the stepping loop and the result is a field of a
record here, and is found by its name. All fields are float64. The number of mounts is the model's own: it is in its
first row, and every table has one record per mount.

- ``mjModel.actuator_user``: an `ISOLATOR` per mount, then rows of actuators that only carry states; a shared supply's
  is a `SUPPLY`.
- ``mjData.act``: an `ISOLATOR_STATE` per mount, then the states of valve options (only of isolators that have them),
  the supply's, the ledger's (`OIL` per mount, then `LEDGER`).
- ``mjData.userdata``: a `STEP`, a `CUBIC` per degree of freedom for the force [N] and moment [N m] at the machine's CG,
  then a `MOUNT` per mount and a `SLIDE` per slide.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.actuator import COMPONENTS, STATEFUL
from ehamj.isolator.component import STAGES, Option
from ehamj.isolator.equations import State
from ehamj.isolator.supply import Feed, Supply, SupplyState
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.plant import Plant

if TYPE_CHECKING:
    from mujoco import MjData, MjModel

DOUBLE: Final = 8
"""Bytes of a number."""


def record(*fields: str | tuple[str, np.dtype[Any]]) -> np.dtype[Any]:
    """A record of floats and of other records, without gaps."""
    return np.dtype([(field, np.float64) if isinstance(field, str) else field for field in fields])


PLACES: Final = {option: f"{option.__name__.lower()}_at" for option in STATEFUL}
"""Field that says where the states of an isolator's option begin among the activations; 0: it has none."""

RATE_ORDER: Final = sorted(PLACES, key=lambda option: min(list(STAGES).index(stage) for stage in option.path))
"""Options with states in the order in which rates of their states come: of the stages at which they take part."""

HEAD: Final = ("mounts", "actuators", "activations", "supply_row", "supply_at", "ledger_at", "level_enough", "slides")
"""What the first row says of the whole model: how many mounts, actuators and activations it has; the row of the shared
supply, and where its states and the ledger's begin among the activations (0: there is none); whether constant
levers serve (1; `ehamj.plant.plant.Plant.level_enough`), so that strokes are linear; how many slides it has."""

ISOLATOR: Final = record(
    *HEAD,
    *Feed._fields,
    *(name for component in COMPONENTS for name in component.Values._fields),
    *PLACES.values(),
    "connected",  # 1: fed by the supply; 0: its branch is cut off
    *(f"mount_{axis}" for axis in AXES),  # [m]
    *(f"along_{axis}" for axis in AXES),  # unit vector of its action, towards the machine
    "height",  # shim below it [m]
    "plate_weight",  # of its plate along its action [N]
    "weight",  # what of it the engine does not put on the plate itself [N]
)
"""An isolator as the compiled code knows it: values of its components, of its place, and of what it is fed with."""

ISOLATOR_STATE: Final = record(*State._fields)
SUPPLY: Final = record(*Supply.Values._fields)
SUPPLY_STATE: Final = record(*SupplyState._fields)

OIL: Final = record("oil_in_1", "oil_in_2")
"""Of each mount: ∫ρQ/ρ₀ dt into each chamber [m³]."""

LEDGER: Final = record(
    "energy_in",  # ∫Σ(enthalpy that flows into chambers) dt [J]
    "piston_work",  # ∫Σp V̇ dt [J]
    "supplied_energy",  # ∫P_s Q_s dt [J]
    "throttled_energy",  # ∫Σ q Δp dt over all edges and leaks [J]
)
"""What crossed the chambers' borders since the start."""


class Cubic(NamedTuple):
    """An input over a step: value and slope·step at its start and at its end."""

    value: float
    slope: float
    end_value: float
    end_slope: float


CUBIC: Final = record(*Cubic._fields)

STEP: Final = record(
    "start",  # time at which the step's cubics begin [s]
    "rate",  # 1/step [1/s]; 0: no inputs, the ground rests and only ctrl commands
    "loaded",  # 1: forces act on the machine itself
)
"""What all mounts share in a step."""

MOUNT: Final = record(
    *((f"ground_{axis}", CUBIC) for axis in AXES),  # [m]
    ("open_loop", CUBIC),  # command beside the controller's [V]
    "ground",  # along the action at the current stage, with shim and turn: length − ground is the stroke [m]
    "ground_rate",  # [m/s]
    "turn",  # what the finite rotation of the foot adds to the length at the current stage [m]
    "turn_rate",  # [m/s]
    "command",  # open-loop command at the current stage [V]
    "switch_start",  # what a command that switches within the step adds at its start [V]
    "switch_middle",
    "switch_end",
    "switching",  # at the current stage [V]
    "into_1",  # flow into the chambers at the current stage [m³/s]
    "into_2",
    "drawn",  # from the supply [m³/s]
    "force",  # of the isolator on its plate, the ground's share included [N]
    "metering",  # where the metering edges stood at the last step [mA]
)
"""What a step hands to a mount, and what the callbacks hand back."""

SLIDE: Final = record(
    "start",  # force of its drive at the start of the step [N]
    "middle",
    "end",
    "place",  # of its joint at the end of the step [m]
    "speed",  # [m/s]
)
"""What a step hands to a slide."""

LOADS_SIZE: Final = len(DOFS) * CUBIC.itemsize

INPUTS: Final = (*AXES, "command")
"""Inputs of a mount, along that axis of `inputs`: displacement of the ground [m], open-loop command [V]."""

COMMAND: Final = INPUTS.index("command")
ORDERS: Final = 3
"""Of each input: its value, slope·step and second derivative."""

MACHINE_BODY: Final = 1
"""Number of the machine's body in the model."""


def inputs(steps: int, mounts: int) -> Array:
    """Room for the inputs of some steps at one end, at rest: (step, mount, input, order); see `INPUTS`, `ORDERS`."""
    return np.zeros((steps, mounts, len(INPUTS), ORDERS))


def size(dtype: np.dtype[Any]) -> int:
    """Numbers in a record."""
    return dtype.itemsize // DOUBLE


def userdata_size(mounts: int, slides: int = 0) -> int:
    """Numbers in the userdata of a model."""
    return (STEP.itemsize + LOADS_SIZE + mounts * MOUNT.itemsize + slides * SLIDE.itemsize) // DOUBLE


# What Python code reads and writes, by name. All are views.


def mounts_of(model: "MjModel") -> int:
    """Number of mounts."""
    return int(model.actuator_user[0, 0])


def slides_of(model: "MjModel") -> int:
    """Number of slides."""
    return int(isolators(model)["slides"][0])


def isolators(model: "MjModel") -> Any:
    """Records of the isolators, (mount,)."""
    return model.actuator_user[: mounts_of(model)].view(ISOLATOR)[:, 0]


def supply(model: "MjModel") -> Any:
    """Record of the shared supply; None where the pressure is constant."""
    row = int(isolators(model)["supply_row"][0])
    return model.actuator_user[row, : size(SUPPLY)].view(SUPPLY)[0] if row else None


class Activations(NamedTuple):
    """States among the activations, as views whose leading axes are those of ``act``."""

    isolators: Any
    """`ISOLATOR_STATE` (…, mount)."""
    options: Array
    """States of valve options (…, state)."""
    supply: Any
    """`SUPPLY_STATE` (…, 1), or (…, 0) where there is none."""
    oil: Any
    """`OIL` (…, mount), or (…, 0) where nothing is balanced."""
    ledger: Any
    """`LEDGER` (…, 1), or (…, 0)."""


def activations(model: "MjModel", act: Array) -> Activations:
    """The states in ``act`` (…, na), which must be contiguous along its last axis."""
    row, n = isolators(model)[0], mounts_of(model)
    own = n * size(ISOLATOR_STATE)
    supply_size = size(SUPPLY_STATE) if row["supply_at"] else 0
    book = n * size(OIL) if row["ledger_at"] else 0
    ends = (model.na - book - (size(LEDGER) if book else 0) - supply_size, supply_size, book)
    at = np.cumsum([0, *ends])
    return Activations(
        act[..., :own].view(ISOLATOR_STATE),
        act[..., own : at[1]],
        act[..., at[1] : at[2]].view(SUPPLY_STATE),
        act[..., at[2] : at[3]].view(OIL),
        act[..., at[3] :].view(LEDGER),
    )


def states_of(model: "MjModel") -> tuple[str, ...]:
    """Names of the activations, in order: of a mount's states with its name after a blank."""
    rows = isolators(model)
    names = [model.actuator(mount).name for mount in range(rows.size)]
    found = [f"{state} {name}" for name in names for state in ISOLATOR_STATE.names or ()]
    for _, state, mount in _option_states(rows):
        found.append(f"{state} {names[mount]}")
    found += (SUPPLY_STATE.names or ()) if rows[0]["supply_at"] else ()
    if rows[0]["ledger_at"]:
        found += [f"{field} {name}" for name in names for field in OIL.names or ()] + list(LEDGER.names or ())
    return tuple(found)


def option_scales(model: "MjModel") -> Array:
    """A small motion of each state of the valves' options, as a step for differences (state,)."""
    rows = isolators(model)
    return np.array([option.scales[option.State._fields.index(state)] for option, state, _ in _option_states(rows)])


def _option_states(rows: Any) -> Iterator[tuple[type[Option], str, int]]:
    for option, field in PLACES.items():
        for mount in np.flatnonzero(rows[field]):
            for state in option.State._fields:
                yield option, state, int(mount)


def step(data: "MjData") -> Any:
    """The step's record in the userdata."""
    return data.userdata[: size(STEP)].view(STEP)[0]


def exchange(data: "MjData", mounts: int) -> Any:
    """Records of the mounts in the userdata, (mount,)."""
    first = (STEP.itemsize + LOADS_SIZE) // DOUBLE
    return data.userdata[first : first + mounts * size(MOUNT)].view(MOUNT)


# What the model's builder fills in.


class Row(NamedTuple):
    """An actuator of the model: name, number of states, and its record."""

    name: str
    states: int
    values: list[float]


def _place(plant: Plant, mount: int) -> dict[str, float]:
    """Where a mount stands, along what it acts, and what its plate weighs there."""
    place, along = plant.positions[mount], plant.directions[mount]
    weight = -plant.actuators[mount].plate_mass * plant.gravity * along[AXES.index("z")]
    return {
        **{f"mount_{axis}": entry for axis, entry in zip(AXES, place, strict=True)},
        **{f"along_{axis}": entry for axis, entry in zip(AXES, along, strict=True)},
        "height": plant.heights[mount],
        "plate_weight": weight,
        # A tendon's armature has inertia but no weight; a plate on its own joint gets both from the engine.
        "weight": weight if plant.plates == "tied" else 0.0,
    }


def rows(plant: Plant) -> list[Row]:
    """The model's actuators: the isolators, then those that carry the states of options, supply and ledger."""
    n = len(plant.mounts)
    table = np.zeros(n, ISOLATOR)
    for mount, actuator in enumerate(plant.actuators):
        connected = plant.mounts[mount] not in plant.cut_off
        pressure = plant.supply.pressure if connected else plant.supply.tank_pressure
        values = {
            **Feed(pressure, plant.supply.tank_pressure, plant.supply.rating_pressure)._asdict(),
            **actuator.record(),
            "connected": float(connected),
            **_place(plant, mount),
            "level_enough": float(plant.level_enough),
            "slides": float(len(plant.slides)),
        }
        for name, value in values.items():
            table[name][mount] = value
    others: list[Row] = []
    at = n * size(ISOLATOR_STATE)
    for option, field in PLACES.items():
        mine = [mount for mount, actuator in enumerate(plant.actuators) if option.on(actuator)]
        own = len(option.State._fields)
        table[field][mine] = at + own * np.arange(len(mine))
        if mine:
            others.append(Row(option.__name__.lower(), own * len(mine), []))
        at += own * len(mine)
    if plant.supply.dynamic:
        table["supply_row"], table["supply_at"] = n + len(others), at
        others.append(Row("supply", size(SUPPLY_STATE), list(Supply.values_of(plant.supply))))
        at += size(SUPPLY_STATE)
    if plant.bookkeeping:
        table["ledger_at"] = at
        others.append(Row("ledger", n * size(OIL) + size(LEDGER), []))
        at += others[-1].states
    table["mounts"], table["actuators"], table["activations"] = n, n + len(others), at
    width = size(ISOLATOR)
    isolators = [
        Row(name, size(ISOLATOR_STATE), list(values))
        for name, values in zip(plant.mounts, table.view(np.float64).reshape(n, width), strict=True)
    ]
    return isolators + [other._replace(values=other.values + [0.0] * (width - len(other.values))) for other in others]
