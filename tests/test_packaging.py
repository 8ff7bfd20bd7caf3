"""What is installed, with what, and under which version: stated once, and the same wherever it is read."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml
from harness import Cli

import ehamj
from ehamj.campaign.plans.kinds import PLANS
from ehamj.extras import EXTRAS

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_there_is_one_version() -> None:
    """The project's is what is installed, cited, and the newest that the changelog tells of."""
    stated = PROJECT["version"]
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    released = re.findall(r"^## \[(\d\S*)\] - (\S+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert ehamj.__version__ == stated
    assert (str(cited["version"]), str(cited["date-released"])) == (stated, released[0][1])
    assert released[0][0] == stated


@pytest.mark.parametrize("package", EXTRAS)
def test_an_extra_brings_what_a_message_says_it_brings(package: str) -> None:
    """Its requirement stands in that extra, and is none of those of the base."""
    name = re.compile(rf"{package.replace('_', '-')}\b", re.IGNORECASE)
    assert any(name.match(one) for one in PROJECT["optional-dependencies"][EXTRAS[package].extra])
    assert not any(name.match(one) for one in PROJECT["dependencies"])


@pytest.mark.parametrize("study", ["footprint", "paper-sensitivity"])
def test_a_study_without_its_package_is_refused_before_it_begins(
    study: str, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in {plan.package for plan in PLANS} - {""}:
        monkeypatch.setitem(__import__("sys").modules, package, None)  # as if it were not installed
    message = cli("study", study).message
    assert re.search(r"plan\.kind = '\w+': needs \w+, which .* pip install 'ehamj\[studies\]'", message)
    assert not list(Path().iterdir())
