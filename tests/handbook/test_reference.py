"""The reference says what the program says: no key, command or channel is missing, and its examples run."""

import json
import re
import shlex
from typing import Any

import numpy as np
import pytest
from control import ss
from harness import Cli

import ehamj
from ehamj.cli.frame import COMMANDS
from ehamj.control import Controller
from ehamj.control.channels import channel_names
from ehamj.identification.file import IdentifyFile
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import check_scenario, scenario_schema
from ehamj.settings import PROVENANCE, schema_of
from ehamj.verify import CASES
from handbook.reference.api import api_pages, inner_names
from handbook.reference.commands import command_pages, commands, examples
from handbook.reference.files import LAW, file_pages
from handbook.reference.histories import history_pages
from handbook.reference.identify import identify_pages
from handbook.reference.keys import key_pages
from handbook.reference.tables import Tables
from handbook.reference.words import allowed, number, value
from handbook.site import ROOT
from handbook.verified import KEPT, verified_pages


def check_places(pages: dict[str, str], schema: dict[str, Any]) -> None:
    """Each key of each table of a schema has a heading under its table, or once for the kinds that share it."""
    headed = set(re.findall(r"^### `[^`]+` \{ #(\S+) \}", "\n".join(pages.values()), re.MULTILINE))
    tables = Tables(schema)
    for top, node in schema["properties"].items():
        assert list(tables.below(top, node)) or top in headed, top
    for name, places in tables.places.items():
        starts = {start for one in places for start in (one.anchor, one.path.split(".")[0])}
        for key in tables.definitions[name]["properties"].keys() - {"kind", *PROVENANCE}:
            assert {f"{start}.{key}" for start in starts} & headed, f"{name}: {key}"


def test_every_key_has_its_place() -> None:
    check_places(identify_pages(), json.loads(schema_of(IdentifyFile)))
    pages = key_pages()
    check_places(pages, json.loads(scenario_schema()))
    gain = pages["reference/keys/isolators.md"].partition("### `flow_gain` { #actuators.NAME.flow_gain }")[2][:400]
    for said in ("oil to the piston", "`1.94e-6`** m³/s/mA", "$K_{Q}$", "badge paper", "number > 0", "1e-15 to 1"):
        assert said in gain
    recommended = pages["reference/keys/isolators.md"].partition("{ #presets }")[2]
    assert "| [`flow_pressure`](#actuators.NAME.flow_pressure) |  | `1.32e-10` |" in recommended


@pytest.mark.parametrize(
    ("node", "said"),
    [
        ({"type": "number", "exclusiveMinimum": 0, "maximum": 1e5}, "number > 0 and ≤ 100000"),
        ({"enum": ["a", "b"]}, '`"a"`, `"b"`'),
        ({"anyOf": [{"type": "integer", "minimum": 2}, {"type": "null"}]}, "whole number ≥ 2"),
        ({"type": "array", "prefixItems": [{"type": "number"}] * 3}, "3 × number"),
        ({"type": "array", "items": {"type": "string"}, "minItems": 1}, "list, at least 1 of: text"),
    ],
)
def test_what_is_allowed_is_said_in_words(node: dict[str, Any], said: str) -> None:
    assert allowed(node) == said


def test_values_are_written_as_toml_has_them() -> None:
    assert [number(one) for one in (1.94e-6, 6.8e8, 9.80665, 14.0)] == ["1.94e-6", "6.8e8", "9.80665", "14"]
    assert value({"kind": "rest", "at": [0.5, True]}) == '{ kind = "rest", at = [0.5, true] }'


def test_every_command_and_option_is_listed_with_examples() -> None:
    pages, shown = command_pages(), examples()
    assert set(shown) == set(COMMANDS)
    for name, command in commands().items():
        page = pages[f"reference/commands/{name}.md"]
        assert all(f"`{one.opts[0]}" in page for one in command.params if one.opts[0].startswith("-"))
        assert all(f"\n{one['line']}\n" in page for one in shown[name])


def test_examples_run(cli: Cli) -> None:
    """In order, in one folder; those that take minutes are understood."""
    known = commands()
    for shown in examples().values():
        for one in shown:
            program, name, *words = shlex.split(one["line"].partition(" > ")[0])
            assert program == "ehamj"
            if one["run"]:
                said = cli(name, *words)
                assert said.code == 0, f"{one['line']}\n{said.err}"
            elif name != "study":  # whose commands below it are sought by name
                read = known[name].make_context(name, list(words)).params
                if "scenario" in read:
                    check_scenario(read["scenario"], read.get("overrides") or ())


def test_every_channel_is_listed() -> None:
    page = history_pages()["reference/results/channels.md"]
    for name in channel_names(("MOUNT",)):
        variable, *rest = name.split(" ")
        assert f"| `{variable}" in page
        assert not rest or rest[-1] == "MOUNT" or f"`{rest[-1]}`" in page


def test_the_keys_of_a_law_are_those_of_its_file() -> None:
    system = ss([], [], [], np.zeros((len(MOUNTS), 1)), dt=1e-4, inputs=["cg_velocity z"])
    assert LAW.keys() == Controller.from_statespace(system).to_dict().keys()
    assert all(f"`{key}`" in file_pages()["reference/results/files.md"] for key in LAW)


def test_every_public_name_has_an_entry() -> None:
    pages = "\n".join(api_pages(ROOT).values())
    assert all(pages.count(f"::: ehamj.{name}\n") == 1 for name in ehamj.__all__)
    assert "ehamj.plant.mounts.MOUNTS" in inner_names(ROOT)
    assert "ehamj.ground.ricker.RickerGround" not in inner_names(ROOT)


def test_the_verified_cases_are_those_of_the_code() -> None:
    kept = json.loads(KEPT.read_text(encoding="utf-8"))["errors"]
    assert set(kept) == set(CASES), "make verified measures cases that are new, and forgets those that are gone"
    assert list(kept) == list(CASES)
    assert all(kept[name] is not None and kept[name] <= case.tolerance for name, case in CASES.items())
    assert verified_pages()["validation/verified.md"].count("\n| ") == 1 + len(CASES)
