"""Measure from events alone how long word stations wait between letters: the mean, the 95th percentile, the idle share.

python3 examples/station_waits.py
python3 examples/station_waits.py 300
"""

import _checkout

_checkout.enter()

import sys
from collections import defaultdict
from statistics import mean, quantiles

from soup_live.warehouse import Warehouse, run
from soup_msgs_py.codes import EventType


def main() -> None:
    """Over so many simulated seconds as the argument says; without it, 60."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    with Warehouse() as warehouse:
        transfer_s = warehouse.scenario.word_station.transfer_s
        last: dict[int, float] = {}  # by station
        waits = defaultdict[int, list[float]](list)
        for event in warehouse.watch(EventType.TRANSFERRED, seconds=seconds):
            if not warehouse.layout.is_word_station(event.station):
                continue
            if event.station in last:  # the event comes when the letter is in place
                waits[event.station].append(max(0.0, event.time - last[event.station] - transfer_s))
            last[event.station] = event.time
        print("word station  letters  mean wait (s)  95 % (s)  idle")
        for station, gaps in sorted(waits.items()):
            most = quantiles(gaps, n=20)[-1] if len(gaps) > 1 else gaps[0]
            idle = sum(gaps) / (sum(gaps) + len(gaps) * transfer_s)
            print(f"{station:12}  {len(gaps) + 1:7}  {mean(gaps):13.2f}  {most:8.2f}  {idle:4.0%}")


if __name__ == "__main__":
    sys.exit(run(main))
