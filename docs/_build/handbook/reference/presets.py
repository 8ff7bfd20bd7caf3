"""What presets, oils and valves set of an isolator, key by key."""

from collections.abc import Mapping
from typing import Any, Final

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import ACTUATOR_PRESETS, OILS, VALVES
from ehamj.settings import PROVENANCE
from handbook.reference.words import value

LONGEST: Final = 30
"""Of a value in a table [characters]; a longer one is said to be a list."""


def preset_section() -> str:
    """Markdown: one table for each of the keys preset, oil and valve; what none of them sets is the key's default."""
    presets = {name: _set_by(one) for name, one in ACTUATOR_PRESETS.items()}
    return "\n".join(
        [
            "## Presets, oils and valves { #presets }\n",
            "What [`preset`](#actuators.NAME.preset) sets; where a cell is empty, the key's default holds, that of the "
            "first generation. Values of your own override all of them.\n",
            _table(presets),
            "What [`oil`](#actuators.NAME.oil) sets (typical, assumed):\n",
            _table(OILS),
            "What [`valve`](#actuators.NAME.valve) sets (typical of catalogues, assumed):\n",
            _table(VALVES),
        ]
    )


def _set_by(preset: Actuator) -> dict[str, Any]:
    """What differs from the defaults."""
    fields = {name: field.default for name, field in type(preset).model_fields.items() if name not in PROVENANCE}
    return {name: getattr(preset, name) for name, default in fields.items() if getattr(preset, name) != default}


def _table(sets: Mapping[str, Mapping[str, Any]]) -> str:
    keys = list(dict.fromkeys(key for one in sets.values() for key in one))
    heads = [f"| key | {' | '.join(f'`{name}`' for name in sets)} |", f"|---|{'---|' * len(sets)}"]
    cells = {key: " | ".join(_cell(one[key]) if key in one else "" for one in sets.values()) for key in keys}
    rows = [f"| [`{key}`](#actuators.NAME.{key}) | {of} |" for key, of in cells.items()]
    return "\n".join([*heads, *rows, ""])


def _cell(given: Any) -> str:
    text = value(given)
    return f"`{text}`" if len(text) <= LONGEST else f"a list of {len(given)}"
