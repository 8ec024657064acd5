"""The coordinated fleet: which policy takes each of its decisions."""

from __future__ import annotations

from typing import Any

from soup_managers.decisions import BOTS, BUCKETS, FILLS, ONWARD, STORAGE
from soup_managers.decisions.bots import BotChoice
from soup_managers.decisions.buckets import BucketChoice
from soup_managers.decisions.fills import FillChoice
from soup_managers.decisions.onward import OnwardChoice
from soup_managers.decisions.storage import StorageChoice
from soup_managers.fleets.minimal.policies import AnyFleet
from soup_managers.state.planning_state import Horizons
from soup_msgs_py.policies import PolicyChoice, load_policy
from soup_msgs_py.reading.options import check_options
from soup_msgs_py.reading.yaml_input import validate

Choice = str | dict[str, Any]


class Coordinated(AnyFleet):
    """A fleet on reserved traffic that decides leg by leg.

    Every choice is the name of a policy that comes with the warehouse, `FILE.py:Class`, or a mapping with `name`
    and `options`.

    Args:
        buckets: Which bucket is fetched for a word station.
        fills: Which bucket is fetched to be filled at a letter station.
        bots: Which bot fetches it.
        storage: Where a bucket is stored.
        onward: Where a bucket goes when a station is done with it.
        horizons: How far the fleet looks ahead; see `Horizons`.
    """

    def __init__(
        self,
        buckets: Choice = "most_tiles_per_second",
        fills: Choice = "emptiest",
        bots: Choice = "nearest",
        storage: Choice = "near_words",
        onward: Choice = "serve_on",
        horizons: dict[str, Any] | None = None,
    ) -> None:
        self.buckets: BucketChoice = _load(buckets, "buckets", BUCKETS, BucketChoice)
        self.fills: FillChoice = _load(fills, "fills", FILLS, FillChoice)
        self.bots: BotChoice = _load(bots, "bots", BOTS, BotChoice)
        self.storage: StorageChoice = _load(storage, "storage", STORAGE, StorageChoice)
        self.onward: OnwardChoice = _load(onward, "onward", ONWARD, OnwardChoice)
        self.horizons = Horizons(**check_options(Horizons, horizons or {}, "fleet policy", "horizons"))


def _load(choice: Choice, decision: str, known: dict[str, Any], base_class: type) -> Any:
    chosen = {"name": choice} if isinstance(choice, str) else choice
    return load_policy(validate(PolicyChoice, chosen, f"{decision} policy"), decision, known, base_class)
