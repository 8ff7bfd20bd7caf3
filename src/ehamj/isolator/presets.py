"""Isolators, oils and valves that a scenario names."""

from collections.abc import Mapping
from typing import Any, Final, Literal

from pydantic import Field, model_validator

from ehamj.isolator.actuator import Actuator
from ehamj.settings import PROVENANCE

FIRST_GENERATION = Actuator.stated()
"""The paper's first prototype (Table I)."""

RECOMMENDED = Actuator.stated(
    chamber_volume=FIRST_GENERATION.chamber_volume / 2,
    piston_area=FIRST_GENERATION.piston_area * 2,
    flow_pressure=FIRST_GENERATION.flow_pressure * 2,
    sources={"chamber_volume": "paper", "piston_area": "paper", "flow_pressure": "paper"},
)
"""The paper's recommendation (section 5): half the volume, twice the area and the flow-pressure coefficient."""

ELASTIC_MOUNT = Actuator.stated(
    passive=True,
    piston_area=1e-6,  # its oil carries 7 N at most, of 10 kN
    membrane_stiffness=1e6,
    membrane_damping=3.2e3,
    lateral_stiffness=5e5,
    lateral_damping=1.6e3,
    sources=dict.fromkeys(
        ("piston_area", "membrane_stiffness", "membrane_damping", "lateral_stiffness", "lateral_damping"), "assumed"
    ),
)
"""A passive spring mount, in place of the actuator: four carry 4 t at 5 Hz vertically, damping ratio 5 %."""

PNEUMATIC_MOUNT = Actuator.stated(
    passive=True,
    # Spring and damping chamber of 2.1 dm³ together at 6 bar, of which n·p·A²/V is membrane_stiffness; what the
    # narrow bore between them adds above its frequency, as much again, is K_h = 4βA²/V_t, with β = n·p.
    piston_area=0.02,
    bulk_modulus=8.4e5,
    chamber_volume=8.4e-3,
    moving_volume=False,  # the pressure carries the weight, and the piston stays in the middle
    flow_pressure=3.75e-8,
    edge_leakage_share=1e-3,
    membrane_stiffness=1.6e5,
    membrane_damping=100.0,
    lateral_stiffness=1e5,
    lateral_damping=1.6e3,
    sources=dict.fromkeys(
        (
            "piston_area",
            "bulk_modulus",
            "chamber_volume",
            "flow_pressure",
            "edge_leakage_share",
            "membrane_stiffness",
            "membrane_damping",
            "lateral_stiffness",
            "lateral_damping",
        ),
        "assumed",
    ),
)
"""A passive air spring with a damping chamber, as a standard linear solid: four carry 4 t at 2 to 2.8 Hz vertically.

Its spring is the membrane's, its bore the leakage across the piston (DeBra, Precision Engineering 1984). Levelling
valves are not modelled: static stiffness is that of the gas.
"""

ACTUATOR_PRESETS: dict[str, Actuator] = {
    "first-generation": FIRST_GENERATION,
    "recommended": RECOMMENDED,
    "elastic-mount": ELASTIC_MOUNT,
    "pneumatic-mount": PNEUMATIC_MOUNT,
}


OILS: dict[str, dict[str, float]] = {
    # The paper's effective modulus, with whatever air and hose it contained.
    "paper": {},
    # Mineral oil at 40 °C and well de-aerated; secant modulus as in textbooks (Merritt; Jelali and Kroll).
    "mineral": {"bulk_modulus": 1.6e9, "air_fraction": 0.005, "vapour_pressure": 10.0},
    # The same with the air of a tank that foams.
    "mineral-aerated": {"bulk_modulus": 1.6e9, "air_fraction": 0.03, "vapour_pressure": 10.0},
    # Fire-resistant HFC fluid: stiffer, and with the vapour pressure of its water at 40 °C.
    "water-glycol": {"bulk_modulus": 3.2e9, "air_fraction": 0.005, "vapour_pressure": 6e3},
}
"""Values that belong to an oil, typical and assumed; those of an actuator's table override them."""

VALVES: dict[str, dict[str, Any]] = {
    # The paper's, of which it states gain and dynamics: zero lap, no friction, as much flow as opening.
    "paper": {},
    # One of those dynamics as it is sold: catalogues of direct-operated proportional valves with position feedback
    # state overlaps of some per cent of the stroke, hysteresis below 0.5 % or so, response to 0.1 to 0.2 %, and a spool
    # notched for fine metering. Here 2 % of 20 mA at each edge, 0.5 %, 0.2 %, and q = 0.6·x + 0.4·x² of full flow and
    # stroke: 0.6 of the gain at null.
    "proportional": {
        "overlap": (0.4, 0.4, 0.4, 0.4),
        "hysteresis": 0.1,
        "threshold": 0.04,
        "flow_curve": tuple((x / 10, round(0.06 * x + 0.004 * x * x, 3)) for x in range(11)),
    },
}
"""Values that belong to a valve, typical and assumed; those of an actuator's table override them."""


class Isolator(Actuator):
    """An actuator as a table [actuators.NAME]: a preset and what differs from it."""

    preset: Literal["first-generation", "recommended", "elastic-mount", "pneumatic-mount"] = Field(
        "first-generation", description="where values that are not given come from"
    )

    oil: Literal["paper", "mineral", "mineral-aerated", "water-glycol"] = Field(
        "paper", description="sets bulk_modulus, air_fraction and vapour_pressure where they are not given"
    )

    valve: Literal["paper", "proportional"] = Field(
        "paper", description="sets overlap, hysteresis, threshold and flow_curve where they are not given"
    )

    @model_validator(mode="before")
    @classmethod
    def _fill_from_preset(cls, table: Any) -> Any:
        if not isinstance(table, Mapping):
            return table
        chosen = {key: table.get(key, cls.model_fields[key].default) for key in NAMED}
        if any(not isinstance(name, str) or name not in NAMED[key] for key, name in chosen.items()):
            return table  # the field's own validation says what is allowed
        preset = ACTUATOR_PRESETS[chosen["preset"]]
        own_values = {**OILS[chosen["oil"]], **VALVES[chosen["valve"]]}
        values = {name: getattr(preset, name) for name in Actuator.model_fields if name not in PROVENANCE} | own_values
        known = {**preset.sources, **dict.fromkeys(own_values, "assumed")}
        sources = {k: v for k, v in known.items() if k not in table or table[k] == values[k]}
        own = table.get("sources", {})
        return {**values, **table, "sources": {**sources, **own} if isinstance(own, Mapping) else own}


NAMED: Final[dict[str, Mapping[str, Any]]] = {"preset": ACTUATOR_PRESETS, "oil": OILS, "valve": VALVES}
"""Keys of an isolator's table that other values of it come from, each with what it may name."""
