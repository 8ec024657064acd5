"""Watch words being completed, while a whole warehouse runs: which, where, and how many a minute.

python3 examples/watch_words.py
python3 examples/watch_words.py 50
"""

import _checkout

_checkout.enter()

import sys

from soup_live.warehouse import Warehouse, run
from soup_msgs_py.codes import EventType


def main() -> None:
    """So many words as the argument says; without it, 10."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    with Warehouse() as warehouse:
        events = warehouse.watch(EventType.WORD_ARRIVED, EventType.WORD_COMPLETED)
        snapshot = warehouse.snapshot()
        words = [*snapshot.waiting_words, *(word for state in snapshot.word_stations for word in state.open_words)]
        texts = {word.word: word.text for word in words}
        number = 0
        while number < count:
            event = next(events)
            if event.sequence <= snapshot.sequence:
                continue  # it came before the snapshot, which does not show a word any more that was completed then
            if event.type is EventType.WORD_ARRIVED:
                texts[event.job] = event.text
                continue
            number += 1
            rate = 60.0 * number / (event.time - snapshot.time)
            place = warehouse.layout.station_name(event.station)
            print(f"{event.time:8.1f} s  {texts[event.job]:16} at {place}  {rate:5.1f} words/min")


if __name__ == "__main__":
    sys.exit(run(main))
