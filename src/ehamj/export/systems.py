"""A subject as linear systems in SI, with the names and units of every signal: plant, plant as a law sees it, law."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.control import Controller, LinearController
from ehamj.control.channels import reads_static
from ehamj.control.law import KEYS
from ehamj.control.units import plain_unit, signal_units
from ehamj.export.subject import Subject
from ehamj.linear.loop import Loop, closed_at_rest, linear_under
from ehamj.linear.machine import linear_model
from ehamj.linear.sampled import sampled_machine
from ehamj.plant.axes import CHAMBERS
from ehamj.views.linear import named_plant
from ehamj.views.statics import static_loads

ABOUT: Final = {
    "plant": "The machine about its rest, continuous. x, u and y are deviations in SI (spools in mA, commands in V); x "
    "is in physical units, over scales its parts are all about one. Displacement and velocity of the ground at each "
    "mount are inputs of their own: feed both, one the integral of the other. Valves, oil, membranes and machine; no "
    "sensor, no delay.",
    "plant_linearised": "The same behind what the law makes good of its valves: its stage, and the loops about spools.",
    "plant_sampled": "The machine as the law sees it, from the commands that it computes at a sample to its readings "
    "at the samples: delay, hold, valves, machine, instruments, behind what the law makes good of its valves. Noise, "
    "range and resolution play no part; what the ground adds to readings is left out. feedback(plant_sampled, law, "
    "+1) has the poles of the loop.",
    "law": "The law from sample to sample: u = readings in SI, y = commands in V, one per valve, which act delay_s "
    "after their sample, add up with those of other parts, fade in, and go limited and rounded to the valves.",
}
BEYOND: Final = {
    "valves": "the stage that makes good what is known of the valves",
    "learners": "what it learns of its valves while it runs",
    "lines": "lines whose frequency it follows",
    "spools": "the loops about the valves' spools",
}
"""What of a law no matrices hold, by the key that its file has."""


SETTINGS: Final = ("delay", "voltage_limit", "bits", "switch_on", "fade", "from_rest", "anti_windup")
"""What of a law stands beside its matrices."""


@dataclass(frozen=True)
class System:
    """x' = A x + B u (of ``dt`` 0) or x⁺ = A x + B u, y = C x + D u, in SI; names and units of x, u and y."""

    name: str
    matrices: tuple[Array, Array, Array, Array]
    dt: float
    """Period of the samples [s]; 0 of a continuous system."""
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    state_units: tuple[str, ...]
    scales: Array
    """Size of each state in a moderate motion, (state,): powers of two."""
    rest: Array
    """Of what the states are deviations, (state,)."""

    @property
    def units(self) -> dict[str, tuple[str, ...]]:
        """Of states, inputs and outputs; '' of a state that an instrument or a law has for itself."""
        signals = {"inputs": signal_units(self.inputs), "outputs": signal_units(self.outputs)}
        return {what: tuple(map(plain_unit, some)) for what, some in {"states": self.state_units, **signals}.items()}

    @classmethod
    def of(cls, plant: Any, name: str) -> "System":
        """An `ehamj.linear.plants.LinearPlant` in SI: its scales are powers of two, so that no digit changes."""
        up, down = plant.scales[:, None], 1.0 / plant.scales
        matrices = (plant.A * up * down, plant.B * up, plant.C * down, plant.D)
        names = (tuple(plant.state_labels), tuple(plant.input_labels), tuple(plant.output_labels))
        return cls(name, matrices, float(plant.dt), *names, plant.state_units, plant.scales, plant.operating_point)


def plant_of(subject: Subject, law: LinearController | None = None) -> System:
    """The machine, continuous, from all inputs to all channels and to the scenario's points; where a ``law`` is given,
    behind what it makes good of its valves."""
    scenario = subject.scenario
    model = linear_under(scenario.plant, law)
    name = subject.name if law is None else f"{subject.name}-linearised"
    return System.of(named_plant(model, scenario.name, points=scenario.points), name)


def plants_of(subject: Subject) -> dict[str, System]:
    """``plant``, and ``plant_linearised`` where a law makes good what it knows of the valves."""
    law = subject.controller
    found = {"plant": plant_of(subject)}
    if law is not None and (law.converter.valves or law.converter.spools):
        found["plant_linearised"] = plant_of(subject, law)
    return found


def parts_of(subject: Subject) -> tuple[Controller, ...]:
    """The laws that run side by side; none of a machine without one."""
    return () if subject.controller is None else subject.controller.parts


def seen_by(subject: Subject) -> tuple[System, ...]:
    """The machine as each part of the law sees it, without the others."""
    law, scenario = subject.controller, subject.scenario
    if law is None:
        return ()
    model = linear_under(scenario.plant, law)
    loops = [Loop.of(scenario, part) for part in law.parts]
    names = _numbered(f"{subject.name}-sampled", len(loops))
    return tuple(System.of(sampled_machine(model, loop), name) for loop, name in zip(loops, names, strict=True))


def laws_of(subject: Subject) -> tuple[System, ...]:
    """Each part of the law; empty where there is none."""
    parts, found = parts_of(subject), []
    for part, name in zip(parts, _numbered(f"{subject.name}-law", len(parts)), strict=True):
        states = tuple(f"law {k}" for k in range(part.states))
        matrices = (part.A, part.B, part.C, part.D)
        sizes = (np.ones(part.states), np.zeros(part.states))
        names = (states, part.inputs, part.outputs)
        found.append(System(name, matrices, part.period, *names, ("",) * part.states, *sizes))
    return tuple(found)


def settings_of(part: Controller) -> dict[str, Any]:
    """What of a law its matrices do not hold, under the keys of its file, as plain data."""
    plain = part.to_dict()
    return {KEYS[name]: plain[KEYS[name]] for name in (*SETTINGS, *BEYOND)}


def _beside(parts: Sequence[Controller]) -> str:
    """Settings beside the matrices that are not those of a law that states none; '' where all are."""
    usual = {one.name: one.default for one in fields(Controller)}
    found: dict[str, None] = {}
    for part in parts:
        own = {name: getattr(part, name) for name in SETTINGS}
        own["delay"] = None if part.latency == part.period else part.delay
        from_rest, windup = own.pop("from_rest"), own.pop("anti_windup")
        said = [f"{KEYS[name]} = {value}" for name, value in own.items() if value != usual[name]]
        said += ["from_rest = false"] if not from_rest and reads_static(part.inputs) else []
        said += ["anti_windup"] if windup is not None else []
        found |= dict.fromkeys(said)
    return ", ".join(found)


def _numbered(name: str, count: int) -> tuple[str, ...]:
    return (name,) if count == 1 else tuple(f"{name}-{k}" for k in range(1, count + 1))


def rest_of(subject: Subject, plant: System) -> dict[str, Any]:
    """The operating point: every state of the plant, and what a person asks for, by mount.

    Raises:
        InputError: if the machine cannot stand.
    """
    states = dict(zip(plant.states, plant.rest.tolist(), strict=True))
    mounts = subject.scenario.plant.mounts
    chambers = {
        f"pressure_{one}": [states[f"pressure_{one} {mount}"] for mount in mounts] for one in CHAMBERS
    }  # of which no mount lacks one
    return {
        "states": list(plant.states),
        "values": plant.rest.tolist(),
        "units": list(map(plain_unit, plant.state_units)),
        "mounts": list(mounts),
        "strokes": {"values": static_loads(subject.scenario).stroke.tolist(), "unit": "m"},
        **{name: {"values": values, "unit": "Pa"} for name, values in chambers.items()},
        "commands": {"values": [0.0] * len(mounts), "unit": "V"},
    }


def plant_notes(subject: Subject) -> tuple[str, ...]:
    """What the plant takes for granted, and what its commands do not do, a sentence each."""
    closed = closed_at_rest(linear_model(subject.scenario.plant))
    said = (
        f"the valves of {', '.join(closed)} pass nothing of a small command as they are (overlap, hysteresis, "
        "threshold), so that in plant their commands do nothing"
    )
    return (*subject.scenario.where_slides_stand, *((said,) if closed else ()))


def what_to_know(subject: Subject) -> tuple[str, ...]:
    """What the systems leave out, or take for granted, a sentence each: of the plant, then of the law."""
    parts = parts_of(subject)
    beyond = [said for key, said in BEYOND.items() if any(getattr(part, key) for part in parts)]
    notes = list(plant_notes(subject))
    if beyond:
        notes.append(f"the law's matrices do not hold {', '.join(beyond)}")
    if lost := _beside(parts):
        notes.append(
            f"a law that comes back as matrices and names alone is without {lost}: change A to D in the exported law, "
            "and bring it back whole"
        )
    if len(parts) > 1:
        rates = ", ".join(f"{1.0 / part.period:g}" for part in parts)
        notes.append(f"the law has several rates, {rates} Hz: plant_sampled is what each part sees without the others")
    return tuple(notes)
