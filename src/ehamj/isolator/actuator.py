"""One isolator as a user writes it: the components that it has, and the options of its valve."""

from typing import Any, Final, Self

from pydantic import Field, model_validator

from ehamj.isolator.component import Component, Option
from ehamj.isolator.cylinder import Cylinder
from ehamj.isolator.edges import Edges
from ehamj.isolator.end_stops import EndStops
from ehamj.isolator.flow_curve import FlowCurve
from ehamj.isolator.fluid import Fluid
from ehamj.isolator.hysteresis import Hysteresis
from ehamj.isolator.membrane import Membrane
from ehamj.isolator.null_drift import NullDrift
from ehamj.isolator.null_offset import NullOffset
from ehamj.isolator.overlap import Overlap
from ehamj.isolator.spool import Spool
from ehamj.isolator.stuck_spool import StuckSpool
from ehamj.isolator.supply import Supply
from ehamj.isolator.threshold import Threshold


def hydraulic_stiffness(bulk_modulus: Any, piston_area: Any, chamber_volume: Any) -> Any:
    """Stiffness of trapped oil, K_h = 4βA_p²/V_t [N/m], of numbers or arrays in SI."""
    return 4.0 * bulk_modulus * piston_area**2 / chamber_volume


def static_stiffness(spring: Any, foot_stiffness: Any) -> Any:
    """A spring with a foot in series [N/m], of numbers or arrays; of an infinite foot the spring alone."""
    return spring / (1.0 + spring / foot_stiffness)


class Actuator(
    # The list of components: another one is another base. From the last to the first is the order of keys and fields,
    # and of what options do at the same stage.
    FlowCurve,
    EndStops,
    Threshold,
    Hysteresis,
    StuckSpool,
    NullDrift,
    NullOffset,
    Overlap,
    Spool,
    Edges,
    Membrane,
    Fluid,
    Cylinder,
):
    """One electro-hydraulic isolator: valve, double-acting cylinder, membrane spring, plate and foot.

    Defaults are the first-generation prototype of the paper (Table I).
    """

    passive: bool = Field(False, description="whether it stands without a valve that obeys: laws leave it out")

    @model_validator(mode="after")
    def _within_the_stroke(self) -> Self:
        for option in OPTIONS:
            for name, (unit, *_) in option.quantities().items():
                value = getattr(self, name)
                if unit == "mA" and max(map(abs, value if isinstance(value, tuple) else (value,))) >= self.spool_stroke:
                    raise ValueError(
                        f"{name} = {value} mA must be smaller than the full stroke, "
                        f"spool_stroke = {self.spool_stroke:g} mA"
                    )
        return self

    def running_on(self, supply: Supply) -> Self:
        """The actuator as stated, but with the flow gain that rated-flow data, if it has them, give it on a supply."""
        if self.rated_flow == 0.0:
            return self
        gain = self.rated_gain(self.spool_stroke, supply)
        return self.with_values({"flow_gain": gain, "sources": {"flow_gain": "given"}})

    def rated_at(self, supply: Supply) -> Self:
        """The same without the rated-flow data, which have done their work: whatever varies the gain finds it alone."""
        return self.running_on(supply).with_values({"rated_flow": 0.0}) if self.rated_flow else self

    def record(self) -> dict[str, float]:
        """What the isolator's record in memory holds of it, by name."""
        return {name: value for c in COMPONENTS for name, value in c.values_of(self)._asdict().items()}

    @property
    def hydraulic_stiffness(self) -> float:
        """Stiffness of the trapped oil, K_h = 4βA_p²/V_t [N/m]."""
        return hydraulic_stiffness(self.bulk_modulus, self.piston_area, self.chamber_volume)

    @property
    def static_stiffness(self) -> float:
        """Stiffness along the isolator against a load that stays [N/m]: the membrane, oil only where nothing leaks, and
        the foot in series."""
        oil = self.hydraulic_stiffness * (self.flow_pressure == 0.0)
        return float(static_stiffness(self.membrane_stiffness + oil, self.foot_stiffness))

    @property
    def foot_share(self) -> float:
        """Share of a constant force on the plate that reaches a machine at rest: all of it through a rigid foot."""
        return 1.0 if self.rigid_foot else self.foot_stiffness / (self.membrane_stiffness + self.foot_stiffness)


COMPONENTS: Final[tuple[type[Component], ...]] = Actuator.__bases__[::-1]
"""Components that take part in the equations, in order."""

OPTIONS: Final = tuple(component for component in COMPONENTS if issubclass(component, Option))
"""Options of the valve, in order."""

STATEFUL: Final = tuple(option for option in OPTIONS if option.State is not None)
"""Those that have states of their own."""
