"""The table [plan] of an identification file: what tests are possible, and what they are for."""

from pydantic import Field

from ehamj.identification.planning.forecast import Free
from ehamj.identification.planning.information import Criterion
from ehamj.identification.planning.instruments import SHARE
from ehamj.identification.planning.kinds import CANDIDATES
from ehamj.identification.planning.limits import Limits
from ehamj.settings import Positive, Settings, one_of


class PlanSettings(Settings):
    """Which tests could be made next."""

    candidates: tuple[one_of(CANDIDATES), ...] | None = Field(  # type: ignore[valid-type]
        None, min_length=1,
        description="tests that could be made; without: sensible ones for the scenario's mounts, points and floor",
    )  # fmt: skip
    duration: Positive = Field(20.0, description="of a test, what is not compared included [s]")
    rate: Positive = Field(2000.0, description="samples of the logger per second [Hz]")
    channels: tuple[str, ...] | None = Field(
        None, description="channels that are recorded; without: what [sensors] can read at the mounts", min_length=1
    )
    noise: dict[str, Positive] = Field(
        {}, description="standard deviation of a sample, by channel or its first word, in the channel's unit [unit]"
    )
    noise_share: Positive = Field(
        SHARE,
        description="noise of channels that noise does not name, beside their instruments', share of their RMS [-]",
    )
    free: tuple[Free, ...] = Field((), description="what of each channel nobody knows, beside its offset: gain, delay")
    limits: Limits = Field(
        Limits.stated(voltage=10.0, stroke=None, force=2000.0), description="what no test may exceed"
    )
    tests: int = Field(4, ge=1, le=50, description="tests of the recommended sequence, at most")
    criterion: Criterion = Field(
        "d",
        description="what the best tests make small: the volume of the uncertainty (d), or the sum of squared "
        "deviations over what they were (a)",
    )
    sharpen: tuple[str, ...] | None = Field(
        None, description="parameters that count, by key; without: all", min_length=1
    )
