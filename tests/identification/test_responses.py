"""A file of frequency responses tells the parameters that shaped it, as well as its coherence says."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ehamj
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.scenario.load import parse_scenario

HERTZ = np.arange(2.0, 200.0, 2.0)
TRUTH = {"machine.mass": 4400.0, "actuators.isolator.flow_gain": 2.3e-6}
AVERAGES = 50.0
OUTPUTS = {"z": ("stroke front-left", "mm"), "p": ("chamber_pressure front-left 1", "bar")}
SIZES = {"mm": 1e3, "bar": 1e-5}
SET = {"plates": "tied"}


def test_a_file_of_responses_is_fitted_as_well_as_it_is_known(tmp_path: Path) -> None:
    """Values of the linear machine with errors of a coherence that falls: true within 3 deviations, which are small."""
    truth = parse_scenario(SET).varied(TRUTH)
    names = [name for name, _ in OUTPUTS.values()]
    exact = linear_model(truth.plant).response(HERTZ, names, ["valve_command front-left"])[:, :, 0]
    random, coherence = np.random.default_rng(2), 0.995 - 0.1 * HERTZ / 200.0
    scatter = np.sqrt((1.0 - coherence) / coherence / AVERAGES / 2.0)
    columns = [HERTZ]
    for k, (_, unit) in enumerate(OUTPUTS.values()):
        errors = random.standard_normal((2, HERTZ.size)) * scatter
        values = exact[:, k] * (1.0 + errors[0] + 1j * errors[1]) * SIZES[unit]
        columns += [values.real, values.imag, coherence]
    heads = [f"{key} {part} [{unit}/V]" for key, (_, unit) in OUTPUTS.items() for part in ("re", "im")]
    title = ",".join(["frequency [Hz]", *heads[:2], "z coh", *heads[2:], "p coh"])
    np.savetxt(tmp_path / "frf.csv", np.column_stack(columns), fmt="%.9g", delimiter=",", header=title, comments="")
    test: dict[str, Any] = {
        "name": "sweep", "kind": "responses", "file": str(tmp_path / "frf.csv"), "averages": AVERAGES,
        "pair": [{"output": key, "input": "u", "real": f"{key} re", "imaginary": f"{key} im",
                  "coherence": f"{key} coh"} for key in OUTPUTS],
        "measurement": {"u": {"channel": "valve_command front-left"},
                        **{key: {"channel": name} for key, (name, _) in OUTPUTS.items()}},
    }  # fmt: skip
    (tmp_path / "machine.toml").write_text('plates = "tied"\n')
    table = {
        "scenario": str(tmp_path / "machine.toml"),
        "parameters": {key: {"bounds": [0.7 * value, 1.4 * value]} for key, value in TRUTH.items()},
        "test": [test],
        "fit": {"starts": 1},
    }
    found = ehamj.identify(table)
    for key, value in TRUTH.items():
        own = found.values[key]
        assert own.value is not None
        assert own.deviation is not None
        assert abs(own.value - value) < 3.0 * own.deviation, key
        assert own.deviation < 0.01 * value
    held = ehamj.identify({**table, "parameters": {"actuators.isolator.flow_gain": {}}})
    assert "times its own noise; the model does not go with it" in "".join(held.notes)
    assert held.notes[-1].startswith("machine.mass")
    assert not any("own noise" in note for note in found.notes)
    wrong = {**table, "test": [{**test, "band": [300.0, 400.0]}]}
    with pytest.raises(InputError, match=r"test\.0\.band = \[300\.0, 400\.0\]: responses are from 2 to 198 Hz"):
        ehamj.identify(wrong)
