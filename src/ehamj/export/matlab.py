"""Plant and law as a MATLAB file of plain structs (version 5), and a script that makes systems of them."""

import json
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.control import Controller
from ehamj.control.law import KEYS
from ehamj.export.subject import Subject
from ehamj.export.systems import (
    ABOUT,
    BEYOND,
    System,
    laws_of,
    parts_of,
    plants_of,
    rest_of,
    seen_by,
    settings_of,
    what_to_know,
)
from ehamj.export.written import Written

HEADER: Final = 116
"""Bytes of text that a file begins with."""
LONGEST_NAME: Final = 63
"""Letters of a name in MATLAB."""
MATRICES: Final = tuple("ABCD")


def script_of(target: Path) -> tuple[Path, ...]:
    """The script beside a file: its name is one that MATLAB can call."""
    name = re.sub(r"\W", "_", target.stem, flags=re.ASCII)
    name = name if name[:1].isalpha() else f"m_{name}"
    return (target.with_name(f"{name[: LONGEST_NAME - 5]}_load.m"),)


def write_matlab(subject: Subject, path: Path) -> Written:
    """Write structs ``plant``, ``plant_sampled`` and ``law`` of matrices and names, and ``ehamj``: what they are of.

    Laws of several rates are struct arrays, ``law(k)`` beside the plant as it sees it, ``plant_sampled(k)``.
    """
    from scipy.io import savemat

    plants, seen, laws, parts = plants_of(subject), seen_by(subject), laws_of(subject), parts_of(subject)
    notes = what_to_know(subject)
    content: dict[str, Any] = {
        "ehamj": {
            "version": version("ehamj"),
            "scenario": subject.scenario.name,
            "toml": subject.scenario.to_toml(),
            "notes": _cells(notes),
        },
        **{
            name: _struct(one, ABOUT[name]) | {"operating_point": _rest(rest_of(subject, one))}
            for name, one in plants.items()
        },
    }
    if laws:
        content["plant_sampled"] = _array([_struct(one, ABOUT["plant_sampled"]) for one in seen])
        content["law"] = _array([
            _struct(one, ABOUT["law"]) | _settings(part) for one, part in zip(laws, parts, strict=True)
        ])  # fmt: skip
    savemat(path, content, do_compression=True, long_field_names=True)
    with path.open("r+b") as file:  # SciPy's own text holds the time: the same export would be another file
        file.write(f"MATLAB 5.0 MAT-file, ehamj {version('ehamj')}".encode().ljust(HEADER))
    script = script_of(path)[0]
    script.write_text(_script(path.name, script.stem, subject, content), encoding="utf-8")
    variables = ", ".join(name for name in content if name != "ehamj")
    return Written(
        {
            path.name: f"structs {variables} and ehamj; in MATLAB or Octave: load('{{path}}')",
            script.name: "makes ss systems of them: run('{path}'); says how they go into Simulink",
        },
        notes,
    )


def _struct(system: System, about: str) -> dict[str, Any]:
    """A system as a struct: matrices, period, names and units as MATLAB's ``ss`` calls them."""
    units = system.units
    named = {
        "StateName": system.states, "StateUnit": units["states"],
        "InputName": system.inputs, "InputUnit": units["inputs"],
        "OutputName": system.outputs, "OutputUnit": units["outputs"],
    }  # fmt: skip
    return {
        **dict(zip(MATRICES, system.matrices, strict=True)),
        "dt": system.dt,
        **{name: _cells(names) for name, names in named.items()},
        "Name": system.name,
        "scales": system.scales[:, None],
        "about": about,
    }


def _settings(part: Controller) -> dict[str, Any]:
    """What of a law stands beside its matrices; what no number holds as a text in JSON."""
    own = settings_of(part)
    beyond = {KEYS[name]: own.pop(KEYS[name]) for name in BEYOND}
    return {key: _value(value) for key, value in own.items()} | {"beyond": json.dumps(beyond)}


def _value(value: Any) -> Any:
    return np.zeros((0, 0)) if value is None else np.array(value) if isinstance(value, list) else value


def _rest(rest: Mapping[str, Any]) -> dict[str, Any]:
    """The operating point as a struct: texts as cells, numbers as columns."""
    found: dict[str, Any] = {}
    for key, value in rest.items():
        if isinstance(value, Mapping):
            found[key] = _rest(value)
        elif isinstance(value, list):
            found[key] = _cells(value) if value and isinstance(value[0], str) else np.array(value)[:, None]
        else:
            found[key] = value
    return found


def _cells(texts: Sequence[str]) -> Array:
    """Texts as a cell array, (text, 1)."""
    cells = np.empty((len(texts), 1), object)
    cells[:, 0] = texts
    return cells


def _array(structs: Sequence[Mapping[str, Any]]) -> Array:
    """Structs of the same fields as a struct array, (1, struct)."""
    found = np.empty((1, len(structs)), [(name, object) for name in structs[0]])
    for k, one in enumerate(structs):
        for name, value in one.items():
            found[name][0, k] = value
    return found


def _script(file: str, name: str, subject: Subject, content: Mapping[str, Any]) -> str:
    """The script beside a file."""
    quoted = file.replace("'", "''")
    parts = (SCRIPT, LINEARISED if "plant_linearised" in content else "", WITH_LAW if "law" in content else "")
    return "".join(parts).format(name=name, file=quoted, scenario=subject.name, version=version("ehamj"))


SCRIPT: Final = """\
% {name}: systems of {file}, which ehamj {version} wrote of the scenario {scenario}.
%
%   plant          the machine about its rest, continuous, as an ss with names and units; all in SI, spools in mA.
%                  bode(plant('machine_velocity z', 'valve_command front-left')) picks by name (MATLAB).
%
% In Simulink: an "LTI System" block (Control System Toolbox) takes plant as it is; a "State-Space" block takes
% data.plant.A, data.plant.B, data.plant.C and data.plant.D, initial states 0 (at rest). Its inputs are those of
% data.plant.InputName, in this order: commands of the valves [V], displacement and velocity of the ground at each
% mount (both are needed, one is the integral of the other), force and moment at the centre of gravity.
data = load(fullfile(fileparts(mfilename('fullpath')), '{file}'));
named = @(sys, s) set(sys, 'StateName', s.StateName(:), 'InputName', s.InputName(:), 'OutputName', s.OutputName(:));
if exist('OCTAVE_VERSION', 'builtin')
  pkg load control
  united = @(sys, s) sys;  % Octave's systems have no units; they are in data.plant.InputUnit and the like
else
  united = @(sys, s) set(sys, 'InputUnit', s.InputUnit(:), 'OutputUnit', s.OutputUnit(:), 'Name', s.Name);
end
made = @(s) united(named(ss(s.A, s.B, s.C, s.D, s.dt), s), s);
plant = made(data.plant);
"""
LINEARISED: Final = """\

%   plant_linearised  the same behind what the law makes good of its valves
plant_linearised = made(data.plant_linearised);
"""
WITH_LAW: Final = """\

%   plant_sampled  the machine as the law sees it: delay, hold, valves, machine, instruments, from sample to sample
%   law            the law from sample to sample
%                  feedback(plant_sampled, law, +1) is the loop that ehamj runs; of several rates both are cells.
%
% The law in Simulink: a "Discrete State-Space" block with law's matrices and sample time data.law.dt reads the signals
% data.law.InputName in SI and gives volts; after it a "Transport Delay" of data.law.delay_s, a "Saturation" of
% +-data.law.voltage_limit_v and a "Quantizer" of 2*voltage_limit_v/2^bits, then plant's first inputs.
% What data.law.beyond says in JSON (a stage that makes the valves linear, learning, lines, spools) is in no matrix;
% data.law.anti_windup (L) belongs into x+ = A x + B u + L (applied - wanted).
% A changed law runs in ehamj. With all else as it was (channels, delay, limits, readings from rest, what is beyond):
%   s = data.law; s.A = law.A; s.B = law.B; s.C = law.C; s.D = law.D; save('law.mat', 's', '-v7')
% (s.anti_windup = [] if its states are others); then in the scenario: [control] kind = "law", file = "law.mat".
% A struct of A, B, C, D, Ts, InputName and OutputName alone acts one period after its sample (delay_s), within 10 V
% (voltage_limit_v) rounded to 16 bits (bits), without fade_s, anti_windup and what is beyond, and reads strokes and
% pressures from where the machine stands (from_rest = true).
plant_sampled = arrayfun(made, data.plant_sampled, 'UniformOutput', false);
law = arrayfun(made, data.law, 'UniformOutput', false);
if numel(law) == 1
  plant_sampled = plant_sampled{{1}};
  law = law{{1}};
end
"""
