"""What customers order and what suppliers bring, as a scenario says it: colours, orders, bundles."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from soup_msgs_py.scenario.parameters import Count, NotNegative, Part, Positive

MOST_PER_HOUR = 360_000.0  # arrivals, a hundred a second: more are never worked off


class ExplicitColours(Part):
    """The share of each colour."""

    kind: Literal["list"] = "list"
    shares: Annotated[list[NotNegative], Field(min_length=1, max_length=10_000)] = Field(
        description="one for each colour; they add up to 1"
    )

    @field_validator("shares")
    @classmethod
    def _add_up(cls, shares: list[float]) -> list[float]:
        if not math.isclose(sum(shares), 1.0, abs_tol=1e-6):
            raise ValueError(f"shares that add up to {sum(shares):g}|shares that add up to 1")
        return shares


class UniformColours(Part):
    """All colours alike."""

    kind: Literal["uniform"]
    count: Annotated[int, Field(ge=1, le=10_000)] = Field(description="how many colours")

    @property
    def shares(self) -> list[float]:
        """The share of each colour."""
        return [1.0 / self.count] * self.count


class ParetoColours(Part):
    """Few colours are popular: a Pareto distribution, for `alpha` 1.16 the classic 80/20 curve."""

    kind: Literal["pareto"]
    count: Annotated[int, Field(ge=1, le=10_000)] = Field(description="how many colours")
    alpha: Annotated[float, Field(gt=1, le=100)] = Field(
        default=1.16, description="the smaller, the more popular the first colours are"
    )

    @property
    def shares(self) -> list[float]:
        """The share of each colour, the most popular first."""
        power = 1.0 - 1.0 / self.alpha
        # rounded, so that the last bits of a power function, which differ between machines, decide nothing
        curve = [round((k / self.count) ** power, 12) for k in range(self.count + 1)]
        return [after - before for before, after in pairwise(curve)]


Colours = Annotated[ExplicitColours | UniformColours | ParetoColours, Field(discriminator="kind")]
PerHour = Annotated[Positive, Field(ge=1e-6, le=MOST_PER_HOUR)]
Factor = Annotated[NotNegative, Field(le=1_000.0)]
DailyProfile = Annotated[list[Factor], Field(min_length=24, max_length=24)]  # factor for each hour of the day


def _check_peak(per_hour: float, profile: list[float]) -> None:
    peak = per_hour * max(profile)
    if peak > MOST_PER_HOUR:
        raise ValueError(f"daily_profile|{peak:g} arrivals in the busiest hour|at most {MOST_PER_HOUR:g}")


class Backlog(Part):
    """Always `visible` waiting words to choose from: a customer whose demand never ends."""

    kind: Literal["backlog"] = "backlog"
    visible: Count = Field(default=200, description="words that wait at any time")


class AllOrders(Part):
    """All orders are known at the start, and no more come."""

    kind: Literal["all"]
    count: Count = Field(description="how many words")


class PoissonOrders(Part):
    """Words arrive at random, `per_hour` on average, times the factor of the hour of the day."""

    kind: Literal["poisson"]
    per_hour: PerHour = Field(description="words on average")
    daily_profile: DailyProfile = Field(default=[1.0] * 24, description="a factor for each hour of the day")
    at_start: Annotated[int, Field(ge=0, le=100_000)] = Field(default=0, description="words that wait at the start")

    @model_validator(mode="after")
    def _not_too_many(self) -> Self:
        _check_peak(self.per_hour, self.daily_profile)
        return self


class OrderFile(Part):
    """Words arrive as a file says: lines of `seconds,word` or `seconds,E0 T1 A0`, in order of time."""

    kind: Literal["file"]
    path: str = Field(description="the file")


class NoOrders(Part):
    """Nobody orders anything."""

    kind: Literal["none"]


Orders = Annotated[NoOrders | Backlog | AllOrders | PoissonOrders | OrderFile, Field(discriminator="kind")]


class ChosenBundles(Part):
    """The letter manager decides which letters come in; any kind can be had at any time."""

    kind: Literal["chosen"] = "chosen"


class PoissonBundles(Part):
    """Bundles of kinds that follow the letters of words arrive at random, `per_hour` on average."""

    kind: Literal["poisson"]
    per_hour: PerHour = Field(description="bundles on average")
    daily_profile: DailyProfile = Field(default=[1.0] * 24, description="a factor for each hour of the day")
    at_start: Annotated[int, Field(ge=0, le=100_000)] = Field(default=0, description="bundles that wait at the start")

    @model_validator(mode="after")
    def _not_too_many(self) -> Self:
        _check_peak(self.per_hour, self.daily_profile)
        return self


class BundleFile(Part):
    """Bundles arrive as a file says: lines of `seconds,E0`, in order of time."""

    kind: Literal["file"]
    path: str = Field(description="the file")


class NoBundles(Part):
    """Nothing comes in."""

    kind: Literal["none"]


Bundles = Annotated[NoBundles | ChosenBundles | PoissonBundles | BundleFile, Field(discriminator="kind")]
