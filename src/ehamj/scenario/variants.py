"""Variants that run beside a scenario: what of it is otherwise, or another control of its kind with all defaults."""

import re
from typing import TYPE_CHECKING, Annotated, Any, Final

from ehamj.control.settings import DigitalSettings
from ehamj.errors import InputError
from ehamj.scenario.keys import entries
from ehamj.scenario.variation import changed
from ehamj.settings import OVERRIDES
from ehamj.synthesis.kinds import STANDARD

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario

Variants = dict[str, Annotated[dict[str, Any], OVERRIDES]]
"""What of a scenario is otherwise, by the variant's name."""
NAME: Final = re.compile(r"(?!figures$)[A-Za-z0-9][A-Za-z0-9_-]*", re.IGNORECASE)
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
                f"variants: {name!r} must be letters, digits, '_' and '-', and not 'figures': it names a folder"
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
            raise ValueError(f"compare.{number} = {name!r}: must be one of {_allowed(scenario)}")


def variant(scenario: "Scenario", name: str) -> "Scenario":
    """A scenario's variant by its name; see `ehamj.scenario.model.Scenario.variant`."""
    if name in scenario.variants:
        return _otherwise(scenario, name)
    if name not in STANDARD:
        raise InputError(f"variant {name!r}: must be one of {_allowed(scenario)}")
    control = STANDARD[name]
    if isinstance(control, DigitalSettings) and isinstance(scenario.control, DigitalSettings):
        control = control.model_copy(update={"designed_for": scenario.control.designed_for})
    return scenario.model_copy(update={"control": control, **_alone(scenario, name)})


def _otherwise(scenario: "Scenario", name: str) -> "Scenario":
    """The scenario with what its variant states."""
    alone = scenario.model_copy(update=_alone(scenario, name))
    return changed(alone, dict(entries(scenario.variants[name])))


def _alone(scenario: "Scenario", name: str) -> dict[str, Any]:
    return {"compare": (), "variants": {}, "name": f"{scenario.name}, {name}"}


def _allowed(scenario: "Scenario") -> str:
    return ", ".join(map(repr, (*scenario.variants, *STANDARD)))
