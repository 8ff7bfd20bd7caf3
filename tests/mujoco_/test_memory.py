"""Memory by name: for the number of mounts of the model."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from ehamj.control.loop import no_loop
from ehamj.isolator.actuator import COMPONENTS, Actuator
from ehamj.isolator.supply import Supply
from ehamj.memory import ISOLATOR, activations, exchange, inputs, isolators, mounts_of, states_of
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import advance
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.model import build_model
from ehamj.mujoco.rows import Recording
from ehamj.plant.mounts import UP
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario
from ehamj.stopped import DONE


def ring(mounts: int) -> Plant:
    """A machine on so many isolators in a circle, with a shared supply and a ledger."""
    angles = 2 * np.pi * np.arange(mounts) / mounts
    return replace(
        parse_scenario({"plates": "tied"}).plant,
        positions=tuple((float(np.cos(angle)), float(np.sin(angle)), 0.0) for angle in angles),
        directions=(UP,) * mounts,
        heights=(0.0,) * mounts,
        actuators=(Actuator(),) * mounts,
        supply=Supply(dynamic=True),
        mounts=tuple(f"m{k}" for k in range(mounts)),
        bookkeeping=True,
    )


@pytest.mark.parametrize("mounts", [3, 5, 8])
def test_a_machine_stands_and_runs_on_any_number_of_mounts(mounts: int) -> None:
    plant = ring(mounts)
    model = build_model(plant, 1e-4)
    data = mujoco.MjData(model)
    with hydraulics():
        equilibrium(model, data, Inputs.rest(model))
        # Σ K_L carries machine and plates: the definition of a spring.
        expected = -plant.gravity * plant.total_mass / (mounts * 6.8e8)
        np.testing.assert_allclose(data.qpos[2], expected, rtol=1e-9)
        start = inputs(51, mounts)
        start[:, :, 2, 0] = 1e-6  # the ground stands a micrometre higher
        record = Recording.of(model, no_loop(mounts), 50, 2)
        stopped, recorded = advance(model, data, 0, 50, (start, start), record, last=True)
    assert (stopped.status, recorded) == (DONE, 2)
    force = exchange(data, mounts)["force"]
    np.testing.assert_allclose(force, force[0], rtol=1e-9)  # on a circle all isolators do the same
    assert record.rows.command.shape == (2, mounts)


def test_states_are_named_in_the_order_of_the_activations() -> None:
    model = build_model(ring(3), 1e-4)
    names = states_of(model)
    assert (mounts_of(model), len(names)) == (3, model.na)
    act = np.arange(model.na, dtype=float)
    parts = activations(model, act)
    assert names[int(parts.isolators["pressure_2"][1])] == "pressure_2 m1"
    assert names[int(parts.supply["line_flow"][0])] == "line_flow"
    assert names[int(parts.oil["oil_in_2"][2])] == "oil_in_2 m2"
    assert names[int(parts.ledger["throttled_energy"][0])] == "throttled_energy"


def test_every_value_of_a_component_is_a_field_of_the_isolators_record() -> None:
    names = [name for component in COMPONENTS for name in component.Values._fields]
    assert len(set(names)) == len(names)  # no two components claim one name
    own = isolators(build_model(ring(3), 1e-4))
    record = Actuator().record()
    assert set(record) == set(names) <= set(ISOLATOR.names)
    for name, value in record.items():
        np.testing.assert_array_equal(own[name], value, err_msg=name)
