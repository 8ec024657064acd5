"""The whole warehouse in one process: the same world and minds as live, their messages carried by a queue."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from soup_bots.crew import FOR_BOTS, Crew
from soup_bots.steering import KNOWN as STEERING
from soup_bots.steering.base import Steering
from soup_managers.explain import Explain, Sink
from soup_managers.fleets.make import check_fleet, load_fleet, make_fleet
from soup_managers.fleets.minimal.policies import AnyFleet
from soup_managers.policies import LETTER, WORD, LetterPolicy, WordPolicy
from soup_managers.stations.letter_manager import LetterManager
from soup_managers.stations.word_manager import WordManager
from soup_managers.view import WarehouseView
from soup_msgs_py import messages as m
from soup_msgs_py.mind import Message
from soup_msgs_py.policies import Policies, load_policy
from soup_msgs_py.routing import HEARERS, Hearer
from soup_msgs_py.scenario import Scenario
from soup_sim.world import World

MOST_SAID = 3  # reasons why tasks wait, of a run that stands still
EventSink = Callable[[m.Event], None]


@dataclass(frozen=True)
class Minds:
    """The policies of a run, made from their names."""

    word: WordPolicy
    letter: LetterPolicy
    fleet: AnyFleet
    bot: Steering


def make_minds(policies: Policies, scenario: Scenario | None = None) -> Minds:
    """Make the policies that a run names.

    Raises:
        InputError: A policy does not exist, its options do not fit, or it is not made for the scenario.
    """
    minds = Minds(
        word=load_policy(policies.word, "word", WORD, WordPolicy),
        letter=load_policy(policies.letter, "letter", LETTER, LetterPolicy),
        fleet=load_fleet(policies.fleet),
        bot=load_policy(policies.bot, "bot", STEERING, Steering),
    )
    if scenario is not None:
        check_fleet(minds.fleet, scenario)
    return minds


class Headless:
    """One run in one process.

    Args:
        world: The world, at its start.
        policies: Which policies to follow.
        seed: Seed of the minds' randomness.
        on_event: Called with every event, in order.
        explain: Is told every decision of the managers.
    """

    def __init__(
        self,
        world: World,
        policies: Policies,
        seed: int,
        on_event: EventSink | None = None,
        explain: Sink | None = None,
    ) -> None:
        self.world = world
        scenario, layout = world.scenario, world.layout
        self._on_event = on_event
        minds = make_minds(policies)
        rngs = [np.random.Generator(np.random.PCG64(s)) for s in np.random.SeedSequence([seed, 1]).spawn(4)]
        view = WarehouseView(scenario, layout)
        profile = self.world.tile_profile
        self.word = WordManager(scenario, layout, minds.word, view, rngs[0], Explain(explain))
        self.letter = LetterManager(scenario, layout, minds.letter, view, rngs[1], profile, Explain(explain))
        self.fleet = make_fleet(scenario, layout, minds.fleet, view, rngs[2], Explain(explain))
        self.crew = Crew(scenario, layout, range(scenario.bots), minds.bot, rngs[3])
        self._all = (self.word, self.letter, self.fleet, self.crew)
        self._queue: deque[tuple[Any, Message]] = deque()
        self._next_sense = 0.0
        snapshot = self.world.snapshot()
        for mind in self._all:
            self._say(mind, mind.handle(snapshot, world.now))
        self._carry()

    def replace(self, role: str, mind: Any) -> None:
        """Put another mind in the place of one, which is told nothing of what was before.

        Args:
            role: `word`, `letter`, `fleet` or `crew`.
            mind: The other one.
        """
        setattr(self, role, mind)
        self._all = (self.word, self.letter, self.fleet, self.crew)

    def tell(self, hearer: Any, message: Message) -> None:
        """Hand a message to a mind or to the world, and carry all that follows from it at this instant."""
        is_world = hearer is self.world
        self._say(hearer, hearer.handle(message) if is_world else hearer.handle(message, self.world.now))
        self._carry()

    def say(self, speaker: Any, messages: list[Message]) -> None:
        """Carry what a mind or the world has said outside of a run, and all that follows from it at this instant."""
        self._say(speaker, messages)
        self._carry()

    @property
    def mistakes(self) -> dict[str, int]:
        """What policies chose that cannot be, and how often."""
        return {line: count for mind in self._all for line, count in mind.mistakes.counts.items()}

    def run(self, until: float) -> None:
        """Run on to a simulated time."""
        world, crew = self.world, self.crew
        while world.now < until:
            target = min(until, min(mind.next_wake for mind in self._all))
            if crew.wants_to_sense:
                target = min(target, self._next_sense)
            target = max(target, world.now)
            said = world.advance(target, pause=True)
            now = world.now
            self._say(world, said)
            self._carry()
            if self.fleet.wants_places:
                self._say(self.fleet, self.fleet.handle(world.bots(), now))
            for mind in self._all:
                if mind.next_wake <= now:
                    self._say(mind, mind.wake(now))
            if now >= self._next_sense and crew.wants_to_sense:
                self._next_sense = now + crew.sense_period_s
                self._say(crew, crew.sense(world.bots(), world.buckets(), now))
            self._carry()

    def stalled(self) -> str:
        """Since when nothing is moved though words are on order, and why; empty where work goes on."""
        why = self.world.stalled()
        if not why:
            return ""
        said = Counter(task.message for task in self.fleet.tasks() if task.message).most_common(MOST_SAID)
        return "; ".join([why, *(f"the fleet says of {count} of its tasks: {message}" for message, count in said)])

    def kill(self, bots: Iterable[int], *, noticed: bool = True) -> None:
        """Have the minds of bots die. Their bodies end what they are at, and stand until they are revived.

        Args:
            bots: Their numbers; those that are dead stay so.
            noticed: Whether who had asked them for something learns that nobody answers.
        """
        for bot in bots:
            if bot in self.crew.minds:
                last = self.crew.kill(bot)
                self._say(self.crew, last if noticed else [])
        self._carry()

    def revive(self, bots: Iterable[int]) -> None:
        """Give dead bots new minds, which know nothing of what the old ones did but what the world tells."""
        dead = [bot for bot in bots if bot not in self.crew.minds]
        self._say(self.crew, self.crew.come_back(dead, self.world.snapshot(), self.world.now))
        self._carry()

    def _say(self, speaker: Any, messages: list[Message]) -> None:
        for message in messages:
            self._queue.append((speaker, message))

    def _carry(self) -> None:
        """Carry messages until nobody has anything left to say at this instant."""
        queue, now, world = self._queue, self.world.now, self.world
        while queue:
            speaker, message = queue.popleft()
            match HEARERS.get(type(message)):
                case Hearer.ALL:
                    if self._on_event is not None:
                        self._on_event(message)
                    for mind in (self.word, self.letter, self.fleet):
                        self._say(mind, mind.handle(message, now))
                    if message.type in FOR_BOTS:
                        self._say(self.crew, self.crew.handle(message, now))
                case Hearer.WORLD:
                    for answer in world.handle(message):
                        if type(answer) is m.Reply:
                            self._say(speaker, speaker.handle(answer, now))
                        else:
                            queue.append((world, answer))
                case Hearer.CREW:
                    self._say(self.crew, self.crew.handle(message, now))
                case Hearer.FLEET:
                    self._say(self.fleet, self.fleet.handle(message, now))
                case Hearer.WORD:
                    self._say(self.word, self.word.handle(message, now))
                case Hearer.ASKER:
                    manager = self.word if message.kind == m.DELIVER else self.letter
                    self._say(manager, manager.handle(message, now))
                case None:
                    pass
