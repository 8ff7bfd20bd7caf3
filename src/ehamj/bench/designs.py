"""Linear designs: one at a time through `ehamj.linearise` and python-control, and many at once as studies take them."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any, Final

import numpy as np

from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import HIGHER, LOWER, Table
from ehamj.bench.runs import medians
from ehamj.linear.loop import Loop, linear_under, own_readings
from ehamj.linear.margins import disk_margin, grid, report
from ehamj.linear.response import machine_channels
from ehamj.merits.applied import scenario_of
from ehamj.merits.catalogue import SOURCES
from ehamj.merits.merit import Design, Failed, Machine
from ehamj.paper.merits import figures_of_merit
from ehamj.plant.axes import AXES
from ehamj.plots.timings import Bars, Panel
from ehamj.scenario.load import load_scenario
from ehamj.views.linear import linearise

NUMBER: Final = 1024
"""Designs that are computed at once in one timing."""
ALONE: Final = 2
"""Designs that are computed one at a time in one timing."""
HERTZ: Final = np.geomspace(1.0, 315.0, 200)
"""Of the transmissibility that is computed one design at a time [Hz]."""
LAWS: Final = ("combined", "lqg")
"""Whose loops are looked at."""
SPREADS: Final = {
    "machine.mass": (3500.0, 4500.0), "machine.cg.2": (0.6, 0.9), "actuators.isolator.flow_gain": (1.7e-6, 2.1e-6),
    "actuators.isolator.bulk_modulus": (6e8, 9e8), "mount.front-left.actuator.flow_pressure": (5e-11, 8e-11),
}  # fmt: skip
"""Between which values designs lie."""
NAMES: Final = {"passive": "passive", **{law: f"under its {law} law" for law in LAWS}}


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    rates = figures["linear_designs"]["rate_over_one_at_a_time"]
    return [Bars("Linear designs at once", f"rate over one at a time ({HIGHER})", rates, {})]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    found = figures["linear_designs"]
    columns = {
        "one at a time [ms]": found["one_at_a_time_ms"],
        "at once [ms]": found["at_once_ms"],
        "rate [-]": found["rate_over_one_at_a_time"],
        "states of the law [-]": found["law_states"],
    }
    words = (
        "A row is what is computed of a design: modes, static stiffness, figures of its actuators and transmissibility "
        "along x, y and z at 200 frequencies (passive); stability, margins and disk margins at all places (under a law "
        "that is held). One at a time from its scenario on, through `ehamj.linearise` and python-control (passive, and "
        "where it is said), or through `linear.margins.report`; at once as studies do, on one thread, "
        f"{found['designs']} designs. Times are per design; {LOWER}; of the rate {HIGHER}. 'passive, plainly' leaves "
        "the response to python-control alone, which loses digits of weak channels."
    )
    rows = {key: NAMES.get(key, key) for key in found["at_once_ms"]}
    return [Table.of("Linear designs", words, "design", columns, rows)]


@part("designs", "linear designs, one at a time and many at once", _panels, read=_tables)
def designs(effort: Effort) -> Figures:
    """Times per design, and the ratios of rates."""
    number = min(NUMBER, effort.steps(NUMBER))
    many, works = drawn(number), dict[str, Callable[[], object]]()
    bare = Machine(load_scenario("vc-c-floor", ["control={kind='passive'}", "compare=[]"]))
    names = passive_merits(bare)
    works["passive at once"] = partial(at_once, bare, many, names)
    works["passive alone"] = partial(_each, partial(passive_alone, bare), many)
    works["passive, plainly alone"] = partial(_each, partial(passive_alone, bare, plainly=True), many)
    states = {}
    for law in LAWS:
        machine = Machine(load_scenario("vc-c-floor", [f"control.kind='{law}'", "compare=[]"]))
        own = machine.scenario.controller()
        assert own is not None
        states[law] = sum(one.states for one in own.parts)
        works[f"{law} at once"] = partial(at_once, machine, many, margin_merits(machine))
        works[f"{law} alone"] = partial(_each, partial(margins_alone, machine, own), many)
        works[f"{law}, python-control alone"] = partial(_each, partial(margins_through_control, machine, own), many)
    times = medians(works, effort.repetitions)
    once = {name: 1e3 * times[f"{name} at once"] / number for name in NAMES}
    once["passive, plainly"] = once["passive"]
    once |= {f"{law}, python-control": once[law] for law in LAWS}
    alone = {name: 1e3 * times[f"{name} alone"] / ALONE for name in once}
    return {
        "linear_designs": {
            "designs": number,
            "at_once_ms": once,
            "one_at_a_time_ms": alone,
            "rate_over_one_at_a_time": {name: alone[name] / once[name] for name in once},
            "law_states": states,
        }
    }


def drawn(number: int, seed: int = 0) -> list[Design]:
    """Designs within `SPREADS`."""
    random = np.random.default_rng(seed)
    shares = random.uniform(size=(number, len(SPREADS)))
    low, high = np.array(list(SPREADS.values())).T
    values = (low + shares * (high - low)).tolist()
    return [Design(k, dict(zip(SPREADS, row, strict=True))) for k, row in enumerate(values)]


def passive_merits(machine: Machine) -> list[str]:
    """Names of all merits of actuators and passive machine."""
    return [name for source in ("actuator", "passive") for name in SOURCES[source].merits(machine)]


def margin_merits(machine: Machine) -> list[str]:
    """Names of all margins, and of stability."""
    return [name for name in SOURCES["loop"].merits(machine) if "margin" in name or name == "loop.stable"]


def at_once(machine: Machine, many: Sequence[Design], names: Sequence[str]) -> list[Mapping[str, float]]:
    """Merits of many designs, block by block as studies cut them."""
    found: list[dict[str, float]] = [{} for _ in many]
    for source in dict.fromkeys(name.partition(".")[0] for name in names):
        own = [name for name in names if name.startswith(f"{source}.")]
        block = SOURCES[source].block
        for first in range(0, len(many), block):
            for k, one in enumerate(SOURCES[source].evaluate(machine, many[first : first + block], own)):
                assert not isinstance(one, Failed), one.reason
                found[first + k] |= one
    return list(found)


def passive_alone(machine: Machine, design: Design, plainly: bool = False) -> tuple[Any, ...]:
    """One design through `ehamj.linearise` and python-control; ``plainly`` with its own frequency response."""
    import control

    scenario = scenario_of(machine, design.values)
    plant = linearise(scenario)
    poles = control.damp(plant, doprint=False)
    outputs = list(machine_channels()[: len(AXES)])
    ground = [name for name in plant.input_labels if name.startswith("ground_displacement")]
    ground += [name for name in plant.input_labels if name.startswith("ground_velocity")]
    picked = plant[outputs, ground]
    picked = control.StateSpace(picked.A, picked.B, picked.C, picked.D) if plainly else picked
    response = control.frequency_response(picked, 2 * np.pi * HERTZ).complex
    forces = [f"cg_force {axis}" for axis in AXES]
    stiffness = 1.0 / np.diag(plant[outputs, forces].dcgain())
    own = scenario.plant
    figures = [figures_of_merit(one, own.total_mass / len(own.mounts)) for one in own.actuators[:1]]
    return poles, response, stiffness, figures


def margins_alone(machine: Machine, law: Any, design: Design) -> Any:
    """One design under a law that is derived already."""
    scenario = scenario_of(machine, design.values)
    loop = Loop.of(scenario, law)
    return report(linear_under(scenario.plant, law), loop)


def margins_through_control(machine: Machine, law: Any, design: Design) -> tuple[Any, ...]:
    """The same through `ehamj.linearise` and python-control: margins of each valve, and the disk of all at once by
    SLICOT, at the law's own frequencies; the law's response is known."""
    import control

    scenario = scenario_of(machine, design.values)
    loop, hertz = Loop.of(scenario, law), grid(law)
    channels = [law.inputs[k] for k in own_readings(law)]
    names, shares = loop.mixtures(channels)
    plant = linearise(scenario)
    valves = [name for name in plant.input_labels if name.startswith("valve_command")]
    omega = 2 * np.pi * hertz
    answer = control.frequency_response(plant[list(names), valves], omega).complex.transpose(2, 0, 1)
    told = _law_response(law, hertz.tobytes())[:, :, own_readings(law)]
    gain = -told @ (loop.sensors.response(channels, hertz)[:, :, None] * (shares @ answer))
    sensitivity = np.linalg.inv(np.eye(len(valves)) + gain)
    single = [control.FRD(1.0 / sensitivity[:, k, k] - 1.0, omega) for k in range(len(valves))]
    return *(control.stability_margins(one) for one in single), disk_margin(sensitivity)


@lru_cache(maxsize=2)
def _law_response(law: Any, hertz: bytes) -> Any:
    return law.response(np.frombuffer(hertz))


def _each(compute: Callable[[Design], object], many: Sequence[Design]) -> None:
    for design in many[:ALONE]:
        compute(design)
