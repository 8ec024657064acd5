"""A live warehouse as a plain script uses it: ask bots and the fleet, wait, watch what happens."""

from __future__ import annotations

import signal
import sys
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

from soup_msgs import action, srv

from soup_live.guest import SILENT_S, Guest
from soup_live.handle import Handle
from soup_live.qos import COMMANDS, EVERY_ONE
from soup_msgs_py import topics
from soup_msgs_py.codes import EventType
from soup_msgs_py.command_line.display import display
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.messages import AssignWord, Bots, Buckets, DeliverGoal, DriveGoal, Event, Point, Snapshot, Stations
from soup_msgs_py.wire import to_ros

INTERRUPTED = 128 + signal.SIGINT


class Warehouse(Guest):
    """A running warehouse of this `ROS_DOMAIN_ID`, from outside.

        with Warehouse() as warehouse:
            drives = [warehouse.drive(0, (10.0, 5.0)), warehouse.drive(1, (12.0, 5.0))]
            print(warehouse.first(*drives).what)
            warehouse.wait(*drives)

    What is asked for gives a `Handle` at once, so that several bots can be at work. Messages come in while a method
    waits. The script is no part of the warehouse: simulated time goes on without waiting for it. When the context is
    left, by Ctrl-C too, what is still under way is cancelled. Timeouts are wall time; `time` and what `watch` is told
    are simulated.

    Bots that a fleet manager has do what it asks for: `drive`, `grab`, `release` and `transfer` are for a world whose
    bots run without one. `deliver` asks the fleet manager.

    One at a time in a process, in its main thread. For `timeout_s`, `time`, `scenario` and `layout` see `Guest`.
    """

    # ---- ask ----------------------------------------------------------------------------------------------

    def drive(self, bot: int, *points: Point) -> Handle:
        """Have a bot drive straight from point to point (m), and stop at the last; its feedback says what it waits for.

        Raises:
            InputError: There is no such bot, or no point.
            RunError: Nobody runs its mind.
        """
        self._check_bot(bot)
        if not points:
            raise InputError("points", "", "none", "one or more (x, y) in metres")
        goal = DriveGoal(bot, 0, tuple((float(x), float(y)) for x, y in points))
        x, y = goal.points[-1]
        name = topics.bot_topic(bot, topics.DRIVE)
        client = self._action_client(action.Drive, name, COMMANDS)
        what = f"bot {bot} drives to ({x:.1f}, {y:.1f})"
        return self._send(client, name, to_ros(goal), what, f"run_bots.py {bot}")

    def grab(self, bot: int, bucket: int = -1) -> Handle:
        """Have a bot lift the bucket that it stands below (-1: whichever)."""
        return self._by_hand(bot, srv.Grab, topics.GRAB, "grabs a bucket", bucket=bucket)

    def release(self, bot: int) -> Handle:
        """Have a bot set its bucket down on the free storage spot where it stands."""
        return self._by_hand(bot, srv.Release, topics.RELEASE, "releases its bucket")

    def transfer(self, bot: int, tile: str = "", *, station: int = -1, job: int = -1) -> Handle:
        """Have a bot move one letter between its bucket and the station where it stands.

        Args:
            bot: Its number.
            tile: Letter and colour, for instance E0; empty for any that fits.
            station: Its number, -1 for the one that is here.
            job: Number of the word or the bundle, -1 for any.
        """
        what = f"transfers {tile or 'a letter'}"
        return self._by_hand(bot, srv.Transfer, topics.TRANSFER, what, tile=tile, station=station, job=job)

    def open_word(self, word: int, station: int) -> Handle:
        """Have the world open a word that waits on a word station with a place free."""
        request, what = to_ros(AssignWord(word, station)), f"word {word} is opened on station {station}"
        return self._call(srv.AssignWord, topics.ASSIGN_WORD, EVERY_ONE, request, what, "run_world.py")

    def deliver(self, word: int, station: int | None = None) -> Handle:
        """Open a word that waits, unless it is open, and have the fleet deliver its letters.

        Args:
            word: Its number, as in `snapshot().waiting_words`.
            station: The word station; without it the one with most places free, or where the word is open.

        Raises:
            InputError: No such word waits or is open.
            RunError: There is no fleet manager, or (`Refused`) the world does not open the word there.
        """
        snapshot = self.snapshot()
        at = {opened.word: state.station for state in snapshot.word_stations for opened in state.open_words}
        words = [*snapshot.waiting_words, *(word for state in snapshot.word_stations for word in state.open_words)]
        wanted = next((each for each in words if each.word == word), None)
        if wanted is None:
            raise InputError("word", "", word, "the number of a word that waits or is open")
        client = self._action_client(action.DeliverLetters, topics.DELIVER_LETTERS, EVERY_ONE)
        self._find_server(client, topics.DELIVER_LETTERS, "run_fleet_manager.py")
        place = at.get(word, station)
        if place is None:
            place = min(snapshot.word_stations, key=lambda state: len(state.open_words)).station
        if word not in at:
            self.wait(self.open_word(word, place))
        # tasks are known by their words: where a word manager has asked for this one, both hear how it ends
        goal = to_ros(DeliverGoal(word, place, word, wanted.missing))
        what = f"{wanted.text} is delivered to station {place}"
        return self._send(client, topics.DELIVER_LETTERS, goal, what, "run_fleet_manager.py")

    # ---- wait ---------------------------------------------------------------------------------------------

    def wait(self, *handles: Handle, timeout_s: float | None = None) -> None:
        """Wait until all have ended well.

        Raises:
            Refused: One of them has not.
            RunError: They take longer than `timeout_s`; they go on.
        """

        def over() -> bool:
            return all(handle.done for handle in handles) or any(
                handle.done and not handle.succeeded for handle in handles
            )

        self._wait(over, handles, timeout_s)
        for handle in handles:
            handle.check()

    def first(self, *handles: Handle, timeout_s: float | None = None) -> Handle:
        """Wait for the first that ends, well or not.

        Raises:
            RunError: None does within `timeout_s`; they go on.
        """
        self._wait(lambda: any(handle.done for handle in handles), handles, timeout_s)
        return next(handle for handle in handles if handle.done)

    def follow(self, handle: Handle) -> Iterator[Any]:
        """Yield the newest feedback of a goal whenever there is some, until it has ended, well or not."""
        while self._spin(lambda: handle.done or handle.news) and handle.news:
            handle.news = False
            yield handle.feedback

    # ---- see ----------------------------------------------------------------------------------------------

    def watch(self, *types: EventType, seconds: float | None = None) -> Iterator[Event]:
        """Yield what happens from now on, in order.

        Args:
            types: What to tell; without any, all.
            seconds: Simulated time after which to end; None for never.

        Raises:
            RunError: Events came faster than the script took them, and some are lost.
        """
        events: deque[Event] = deque()
        self._watches.append(events)
        return self._watched(events, types, None if seconds is None else self.time + seconds)

    def bots(self) -> Bots:
        """All bots as they are now: places, velocities, buckets."""
        return self._fresh(Bots)

    def buckets(self) -> Buckets:
        """All buckets as they are now: places, bots, numbers of tiles."""
        return self._fresh(Buckets)

    def stations(self) -> Stations:
        """All stations as they are now: open words, staged bundles."""
        return self._fresh(Stations)

    def snapshot(self) -> Snapshot:
        """Everything, contents of buckets and waiting words included, as it was at most a second ago.

        All events that have been heard of are in it.
        """
        heard = self._sequence
        self._newest.pop(Snapshot, None)
        if not self._spin(lambda: Snapshot in self._newest and self._newest[Snapshot].sequence >= heard, SILENT_S):
            raise RunError(f"no snapshot holds event {heard} after {SILENT_S:g} s")
        return self._newest[Snapshot]

    def pose(self, bot: int) -> tuple[float, float, float]:
        """Where a bot is now: x, y (m) and heading (rad).

        Raises:
            InputError: There is no such bot.
        """
        self._check_bot(bot)
        bots = self.bots()
        return float(bots.x[bot]), float(bots.y[bot]), float(bots.heading[bot])

    def _check_bot(self, bot: int) -> None:
        if not 0 <= bot < self.scenario.bots:
            raise InputError("bot", "", bot, f"0 to {self.scenario.bots - 1}, which the warehouse has")

    def _by_hand(self, bot: int, kind: Any, name: str, does: str, **request: Any) -> Handle:
        self._check_bot(bot)
        topic = topics.bot_topic(bot, name)
        return self._call(kind, topic, COMMANDS, kind.Request(**request), f"bot {bot} {does}", f"run_bots.py {bot}")

    def _wait(self, until: Callable[[], bool], handles: tuple[Handle, ...], timeout_s: float | None) -> None:
        if not self._spin(until, timeout_s):
            late = next(handle for handle in handles if not handle.done)
            why = getattr(late.feedback, "message", "")
            raise RunError(f"{late.what}: takes longer than {timeout_s:g} s" + (f" ({why})" if why else ""))

    def _watched(self, events: deque[Event], types: tuple[EventType, ...], end: float | None) -> Iterator[Event]:
        last = None
        try:
            while self._spin(lambda: bool(events) or (end is not None and self.time > end)) and events:
                event = events.popleft()
                if last is not None and event.sequence > last + 1:
                    raise RunError(f"events {last + 1} to {event.sequence - 1} were missed")
                last = event.sequence
                if end is not None and event.time > end:
                    return
                if not types or event.type in types:
                    yield event
        finally:
            self._watches.remove(events)


def run(main: Callable[[], object]) -> int:
    """Run a script's main function; its exit status: 0 done, 1 it failed, 2 its input is wrong, 130 Ctrl-C.

    What the warehouse refuses is told in one line. Faults of the script itself are not caught.
    """
    try:
        with display():
            main()
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0
