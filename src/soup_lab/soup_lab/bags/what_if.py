"""What if: a recorded warehouse runs on in one process from a moment of its bag, with the same policies or others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rich.table import Table
from soup_msgs import msg

from soup_lab.bags.course import Course, read_course
from soup_lab.bags.interfaces import is_installed
from soup_lab.bags.reader import Bag
from soup_lab.bags.summary import summarize
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError
from soup_msgs_py.figures import known, told
from soup_msgs_py.messages import WorldState
from soup_msgs_py.policies import NONE, ROLES, Policies, PolicyChoice, policies_of
from soup_msgs_py.scenario import load_words
from soup_msgs_py.wire import Announcement, MalformedMessage, from_cdr
from soup_sim.arrivals import read_timed_bundles, read_timed_words
from soup_sim.checkpoint import apply_checkpoint
from soup_sim.scenario_loader import Warehouse
from soup_sim.world import World

SHOWN = (
    "words_completed", "letters_in_words", "words_per_second", "fraction_of_bound", "letters_dispensed",
    "distance_total_m", "grabs", "bot_collisions", "bucket_collisions", "bot_idle_fraction", "inventory_fill_end",
    "violations",
)  # fmt: skip


@dataclass(frozen=True)
class Moment:
    """A warehouse at a moment of its bag.

    Attributes:
        announcement: What the world said of its run.
        warehouse: The warehouse.
        state: The checkpoint that the moment is taken from.
        course: What happened from the beginning of the bag to its end.
        source: The bag, for messages to a person.
    """

    announcement: Announcement
    warehouse: Warehouse
    state: WorldState
    course: Course
    source: str

    def world(self) -> World:
        """The world as it was; its figures count from now on, or from the end of the warm-up."""
        world = self.warehouse.world(self.announcement.seed, self.announcement.warmup_s)
        apply_checkpoint(self.state.checkpoint, world, self.source)
        if world.now >= self.announcement.warmup_s:
            world.count_anew()
        return world

    def policies(self, known: Policies, overrides: Mapping[str, str | None]) -> Policies:
        """The policies of the recorded run, as far as nobody wants others.

        A bag tells the names of policies, not their options: those of a policy in `known` are taken.
        """
        recorded = policies_of(self.course.parts)
        chosen: dict[str, PolicyChoice] = {}
        for role in ROLES:
            usual, theirs = getattr(known, role), getattr(recorded, role)
            chosen[role] = usual if overrides.get(role) or theirs.name in (usual.name, NONE) else theirs
        return Policies(**chosen)

    def original(self) -> dict[str, Any]:
        """The figures of the recorded run over the same time."""
        return summarize(self.course, max(self.state.time, self.announcement.warmup_s))


def take_moment(bag: Bag, at: float, until: float | None) -> Moment:
    """Take the newest checkpoint at a moment, or before.

    Args:
        bag: The bag.
        at: The moment (simulated s).
        until: What follows is of interest up to this time (simulated s); without: to the end of the bag.

    Raises:
        InputError: The bag is none of a warehouse, or holds no checkpoint so early.
    """
    first = next(iter(bag.messages([topics.STATE])), None)
    if first is None:
        raise InputError(bag.folder, topics.STATE, "no checkpoint", "a bag of a whole warehouse")
    if not is_installed(bag.kinds[topics.STATE], bag.definitions[topics.STATE]):
        raise InputError(
            bag.folder, topics.STATE, "checkpoints of another version", "those of the one that is installed"
        )
    begin = _read(bag, topics.STATE, first[2], msg.WorldState).time
    end = bag.simulated(bag.last)
    if not begin <= at < end:
        raise InputError("--at", "", f"{at:g} s", f"{begin:g} to {end:g} s, for which the bag holds checkpoints")
    instant = bag.instant(at)
    found = bag.newest([topics.SCENARIO, topics.STATE], instant)
    if topics.SCENARIO not in found:
        raise InputError(bag.folder, topics.SCENARIO, f"no message before {at:g} s", "a bag of a whole warehouse")
    announcement = _read(bag, topics.SCENARIO, found[topics.SCENARIO][2], msg.Scenario)
    scenario, source = announcement.scenario, str(bag.folder)
    warehouse = Warehouse(
        scenario,
        announcement.layout,
        load_words(scenario, source),
        read_timed_words(scenario, source),
        read_timed_bundles(scenario, source),
    )
    course = read_course(bag, stop=end if until is None else until)
    if course.start is None:
        raise InputError(bag.folder, topics.SNAPSHOT, "no message", "a bag of a whole warehouse")
    state = _read(bag, topics.STATE, found[topics.STATE][2], msg.WorldState)
    return Moment(announcement, warehouse, state, course, source)


def _read(bag: Bag, name: str, cdr: bytes, kind: type) -> Any:
    try:
        return from_cdr(cdr, kind)
    except MalformedMessage as error:
        found = f"a message that makes no sense ({error})"
        raise InputError(bag.folder, name, found, "what a world says") from error


def beside(original: dict[str, Any], other: dict[str, Any], begin: float) -> Table:
    """The recorded figures and the new ones side by side."""
    title = f"From {begin:g} s to {other['sim_seconds']:g} s"
    shown = Table("figure", "recorded", "what if", "unit", title=title, title_justify="left")
    for column in shown.columns[1:3]:
        column.justify = "right"
    for role in ROLES:
        shown.add_row(f"policy, {role}", original["policies"][role], other["policies"][role])
    for key in SHOWN:
        figure = known(key)
        shown.add_row(figure.words, told(key, original[key]), told(key, other[key]), figure.unit)
    return shown
