"""Variants that run beside a scenario: what of it is otherwise, or another control of its kind with all defaults."""

import re
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from ehamj.control.settings import DigitalSettings
from ehamj.errors import InputError, did_you_mean
from ehamj.scenario.keys import entries
from ehamj.scenario.variation import changed
from ehamj.settings import OVERRIDES
from ehamj.synthesis.kinds import STANDARD

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario

Variants = dict[str, Annotated[dict[str, Any], OVERRIDES]]
"""What of a scenario is otherwise, by the variant's name."""
NAME: Final = re.compile(r"(?!figures$)[A-Za-z0-9][A-Za-z0-9_-]{0,63}", re.IGNORECASE)
"""What may be a variant's folder beside a result's files and its folder of figures."""
OWN: Final = ("name", "description", "compare", "variants")
"""Keys that a variant does not change: what the whole is called, and what runs beside it."""


def check_variants(scenario: "Scenario") -> None:
    """Refuse variants that cannot be, and names of none.

    Raises:
        ValueError: with a message that names the key, the value and what is allowed.
    """
    for name, table in scenario.variants.items():
        if name.casefold() in STANDARD:
            raise ValueError(f"variants.{name}: is the name of a standard control; choose another")
        if not NAME.fullmatch(name):
            raise ValueError(
                f"variants: {name!r} must be letters, digits, '_', '-' (64 at most), not 'figures': it names a folder"
            )
        if sum(other.casefold() == name.casefold() for other in scenario.variants) > 1:
            raise ValueError(f"variants.{name}: another one has this name but for capitals, and would have its folder")
        own = [key for key in OWN if key in table]
        if own:
            raise ValueError(f"variants.{name}.{own[0]}: cannot differ in a variant; state it once, for the scenario")
        try:
            _otherwise(scenario, name)
        except InputError as error:
            raise ValueError("\n".join(f"variants.{name}: {line}" for line in str(error).splitlines())) from error
    for number, name in enumerate(scenario.compare):
        if name not in scenario.variants and name not in STANDARD:
            raise ValueError(f"compare.{number} = {name!r}: {_allowed(scenario, name)}")
        if name in scenario.compare[:number]:
            raise ValueError(f"compare.{number} = {name!r}: stands there twice; each variant runs once")


def variant(scenario: "Scenario", name: str) -> "Scenario":
    """A scenario's variant by its name; see `ehamj.scenario.model.Scenario.variant`."""
    if name in scenario.variants:
        return _otherwise(scenario, name)
    if name not in STANDARD:
        raise InputError(f"variant {name!r}: {_allowed(scenario, name)}")
    control = STANDARD[name]
    if isinstance(control, DigitalSettings) and isinstance(scenario.control, DigitalSettings):
        control = control.model_copy(update={"designed_for": scenario.control.designed_for})
    return scenario.model_copy(update={"control": control, **_alone(scenario, name)})


def known_variants(scenario: "Scenario") -> dict[str, str]:
    """Every variant that a scenario may have: its scenario's name → the variant's own."""
    return {_full_name(scenario, name): name for name in (*scenario.variants, *STANDARD)}


def labels(scenarios: Sequence["Scenario"], folders: Sequence[Path] = ()) -> list[str]:
    """What each of several scenarios is called where they stand beside each other: what tells it from the others.

    A scenario beside its variants is called by the kind of its control, these by their names; scenarios that are not of
    one family by their own names. What would be alike has in brackets as much of its folder's path as it takes.

    Args:
        scenarios: at least one; without folders no two have one name.
        folders: that each is from, no two alike.
    """
    family = next((known_variants(one) | {one.name: ""} for one in scenarios if _of_one(scenarios, one)), {})
    names, whole = [family.get(one.name) or one.control.kind for one in scenarios], [one.name for one in scenarios]
    if not family or len(set(names)) < len(set(whole)):
        names = whole
    found, depths = names, count(1)
    while len(set(found)) < len(folders):
        depth = next(depths)
        found = [
            f"{name} ({Path(*folder.parts[-depth:])})" if names.count(name) > 1 else name
            for name, folder in zip(names, folders, strict=True)
        ]
    return found


def _of_one(scenarios: Sequence["Scenario"], first: "Scenario") -> bool:
    """Whether all are a scenario and its variants."""
    return {one.name for one in scenarios} <= {first.name, *known_variants(first)}


def _otherwise(scenario: "Scenario", name: str) -> "Scenario":
    """The scenario with what its variant states."""
    alone = scenario.model_copy(update=_alone(scenario, name))
    return changed(alone, dict(entries(scenario.variants[name])))


def _alone(scenario: "Scenario", name: str) -> dict[str, Any]:
    return {"compare": (), "variants": {}, "name": _full_name(scenario, name)}


def _full_name(scenario: "Scenario", name: str) -> str:
    """Name of a variant's scenario."""
    return f"{scenario.name}, {name}"


def _allowed(scenario: "Scenario", name: str) -> str:
    known = (*scenario.variants, *STANDARD)
    return f"{did_you_mean(name, known)}must be one of {', '.join(map(repr, known))}"
