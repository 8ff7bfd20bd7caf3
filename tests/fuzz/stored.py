"""Laws and result folders that are damaged, renamed or mixed with those of others."""

import copy
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from random import Random
from tempfile import mkdtemp
from typing import Any

import h5py
import numpy as np
import tomli_w
from oracles.damage import damaged

from ehamj.plant.mounts import MOUNTS
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from fuzz.case import Case
from fuzz.together import law_file
from fuzz.values import DEEP, HUGE, wild

OFF = {"replay": False, "report": False}
NOISY = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}, "spool": {}}
MACHINES: dict[str, dict[str, Any]] = {
    "one": {"control": {"kind": "combined"}, "ground": {"kind": "broadband"}},
    "learning": {
        "control": {"kind": "combined", "learning": {}, "linearisation": {}, "spool_feedback": {}},
        "sensors": NOISY,
    },
    "adaptive": {"control": {"kind": "adaptive", "lines": [24.5]}},
    "three": {
        "mount": [{"name": n, "position": p} for n, p in (("a", [0.9, 0.0]), ("b", [-0.8, 0.5]), ("c", [-0.8, -0.5]))],
        "control": {"kind": "feedforward"},
    },
    "passive": {"ground": {"kind": "sine"}},
}
"""Machines whose results are stored: their laws hold valves, learners, spools and lines."""


def results(kept: Path) -> dict[str, Path]:
    """Folders of results, made once."""
    found = {name: kept / f"result-{name}" for name in MACHINES}
    for name, folder in found.items():
        if folder.is_dir():
            continue
        table = {"name": name, "duration": 0.05, "plates": "tied", "output": OFF, **MACHINES[name]}
        made = Path(mkdtemp(dir=kept))
        simulate(parse_scenario(table)).write(made)
        try:
            made.rename(folder)
        except OSError:  # another worker was first
            shutil.rmtree(made)
    return found


def law(random: Random, kept: Path) -> Case:
    """A law's file with something in it as it must not be, before a scenario that runs it."""
    folders = results(kept)
    name = random.choice([one for one in folders if one != "passive"])
    table = {
        "name": "law",
        "duration": 0.02,
        "output": OFF,
        **{k: v for k, v in MACHINES[name].items() if k == "mount"},
    }
    text = (folders[name] / "controller.json").read_text()
    if random.random() < 0.2:
        text = law_file(list(MOUNTS), 1e3)
        table.pop("mount", None)
    content, told = _json_harmed(random, text)
    scenario = tomli_w.dumps({**table, "control": {"kind": "law", "file": "law.json"}}).encode()
    run = ("run", "x.toml", "--out", "out", "--json")
    return Case(
        {"x.toml": scenario, "law.json": content}, (run,), ("control.file", *told), " ".join(told), damaged=True
    )


def result(random: Random, kept: Path) -> Case:
    """A result's folder with something in it as it must not be, before what opens it."""
    folders = results(kept)
    name = random.choice(list(folders))
    file = random.choice([one.name for one in sorted(folders[name].iterdir())])
    content = (folders[name] / file).read_bytes()
    other = random.choice([one for one in folders if one != name])
    how = random.random()
    keys: tuple[str, ...] = (file,)
    if how < 0.2 and (folders[other] / file).is_file():
        content, told = (folders[other] / file).read_bytes(), (f"{file} of {other}",)
    elif file.endswith(".json") and how < 0.75:
        content, told = _json_harmed(random, content.decode())
    elif file == "result.nc" and how < 0.75:
        content, told = _channels_harmed(random, content, kept)
    else:
        content = damaged(content, np.random.default_rng(random.randrange(2**32)), 4096, texts=True)
        told = (f"bytes of {file}",)
    commands = [
        ("report", "result"),
        ("replay", "result", "--json"),
        ("transmissibility", "result", "--json"),
    ]
    command: tuple[str, ...] = random.choice(commands)
    if random.random() < 0.15:
        command = ("report", "good", "--compare", "result")
    good = {"good": folders["one"]} if "good" in command else {}
    return Case(
        {f"result/{file}": content}, (command,), (*keys, "result", *told), f"{name}: {' '.join(told)}",
        {"result": folders[name], **good}, damaged=True,
    )  # fmt: skip


def _json_harmed(random: Random, text: str) -> tuple[bytes, tuple[str, ...]]:
    """JSON with a value, a key or bytes as they must not be; what was changed."""
    if random.random() < 0.25:
        content = damaged(text.encode(), np.random.default_rng(random.randrange(2**32)), 600, texts=True)
        return content, ("bytes",)
    table = json.loads(text)
    changed = [_harm(random, table) for _ in range(random.choice([1, 1, 1, 2]))]
    made = json.dumps(table, default=str).replace(f'"{DEEP}"', "[" * 3000 + "]" * 3000).replace(f'"{HUGE}"', "9" * 400)
    return made.encode(), tuple(changed)


def _harm(random: Random, table: Any) -> str:
    holder, steps = table, []
    while True:
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        key = random.choice(keys)
        steps.append(str(key))
        inner = holder[key]
        if not isinstance(inner, dict | list) or not inner or random.random() < 0.25:
            break
        holder = inner
    how = random.randrange(6)
    if how == 0 and isinstance(holder, dict):
        del holder[key]
    elif how == 1 and isinstance(holder, dict):
        holder[random.choice([f"{key}s", str(key).upper(), "", "a" * 2000, "ключ"])] = holder.pop(key)
    elif how == 2 and isinstance(holder, list):
        holder.append(copy.deepcopy(inner))
    else:
        holder[key] = wild(random, inner)
    return ".".join(steps)


Harm = Callable[[Random, h5py.File], str]


def _channels_harmed(random: Random, content: bytes, kept: Path) -> tuple[bytes, tuple[str, ...]]:
    """A file of histories whose arrays are other ones."""
    path = Path(mkdtemp(dir=kept)) / "x.nc"
    path.write_bytes(content)
    with h5py.File(path, "r+") as file:
        told = random.choice(HARMS)(random, file)
    made = path.read_bytes()
    shutil.rmtree(path.parent)
    return made, (told,)


def _arrays(file: h5py.File) -> list[str]:
    return sorted(name for name, one in file.items() if isinstance(one, h5py.Dataset) and one.ndim)


def _time_at_rest(random: Random, file: h5py.File) -> str:
    file["time"][:] = random.choice([0.0, np.nan, -1.0, np.inf, 1e300])
    return "time"


def _time_backwards(random: Random, file: h5py.File) -> str:
    file["time"][:] = file["time"][:][::-1]
    return "time"


def _time_uneven(random: Random, file: h5py.File) -> str:
    file["time"][:] = np.sort(np.random.default_rng(random.randrange(100)).random(file["time"].size))
    return "time"


def _without(random: Random, file: h5py.File) -> str:
    name = random.choice(_arrays(file))
    del file[name]
    return name


def _other_values(random: Random, file: h5py.File) -> str:
    name = random.choice([one for one in _arrays(file) if file[one].dtype.kind == "f"])
    file[name][...] = random.choice([np.nan, np.inf, 1e300, -1e300, 0.0])
    return name


def _renamed(random: Random, file: h5py.File) -> str:
    name = random.choice(_arrays(file))
    file.move(name, f"{name}_x")
    return name


def _mounts_renamed(random: Random, file: h5py.File) -> str:
    names = file["mount"][:]
    file["mount"][:] = random.choice([names[::-1], np.full_like(names, names[0]), np.full_like(names, b"other")])
    return "mount"


def _exchanged(random: Random, file: h5py.File) -> str:
    one, other = random.sample(_arrays(file), 2)
    file.move(one, "between")
    file.move(other, one)
    file.move("between", other)
    return f"{one} {other}"


def _of_words(random: Random, file: h5py.File) -> str:
    name = random.choice(_arrays(file))
    shape = file[name].shape
    del file[name]
    file[name] = np.full(shape, b"word")
    return name


def _shorter(random: Random, file: h5py.File) -> str:
    name = random.choice(_arrays(file))
    values = file[name][:1]
    del file[name]
    file[name] = values
    return name


HARMS: tuple[Harm, ...] = (
    *(_time_at_rest, _time_backwards, _time_uneven, _without, _other_values),
    *(_renamed, _mounts_renamed, _exchanged, _of_words, _shorter),
)
