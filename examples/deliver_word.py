"""Have the fleet deliver a word, and say which letters are still to come; a word manager may run or not.

python3 examples/deliver_word.py
"""

import _checkout

_checkout.enter()

import sys

from soup_live.warehouse import Warehouse, run
from soup_msgs_py.codes import EventType
from soup_msgs_py.warehouse.tiles import tile_name


def main() -> None:
    """The open word that lacks most; where none is open, since no word manager runs, the shortest that waits."""
    with Warehouse() as warehouse:
        snapshot = warehouse.snapshot()
        opened = [word for station in snapshot.word_stations for word in station.open_words]
        if opened:
            word = max(opened, key=lambda word: len(word.missing))
        else:
            word = min(snapshot.waiting_words, key=lambda word: len(word.tiles))
        completed = warehouse.watch(EventType.WORD_COMPLETED)
        delivery = warehouse.deliver(word.word)
        for feedback in warehouse.follow(delivery):
            missing = " ".join(tile_name(tile) for tile in feedback.missing)
            print(f"{word.text} lacks {missing} {feedback.message}")
        warehouse.wait(delivery)
        event = next(event for event in completed if event.job == word.word)
        print(f"{word.text} is complete after {event.time:.1f} s")


if __name__ == "__main__":
    sys.exit(run(main))
