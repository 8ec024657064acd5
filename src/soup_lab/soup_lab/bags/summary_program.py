"""The program behind `scripts/bag_summary.py`: the figures of a run from its bag alone."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from soup_lab.bags.arguments import parse_summary
from soup_lab.bags.course import Course, read_course
from soup_lab.bags.judge import Verdict, judge_course
from soup_lab.bags.reader import Bag, open_bag
from soup_lab.bags.summary import differences, summarize
from soup_msgs_py.command_line.display import on_display
from soup_msgs_py.errors import InputError
from soup_msgs_py.figures import known
from soup_msgs_py.reading.files import read_text
from soup_sim.summary import table, write_summary

FIGURES = "a summary that --summary has written"
LARGEST_SUMMARY_BYTES = 10_000_000


@on_display
def main(argv: Sequence[str] | None = None) -> int:
    """Write the summary, print the table; the exit status: 1 where counted figures differ."""
    options = parse_summary(argv)
    console = Console()
    try:
        theirs = read_summary(options.compare) if options.compare is not None else None
        with open_bag(options.folder.absolute()) as bag:
            course = read_course(bag)
            verdict = judge_course(course)
            summary = summarize(course, options.warmup, verdict)
            told = tell(bag, course, verdict)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    written = write_summary(options.summary, summary)
    console.print(table(summary))
    console.print(told, highlight=False)
    differ = compare(console, summary, theirs) if theirs is not None else 0
    return differ if written else 1


def read_summary(path: Path) -> dict[str, Any]:
    """Read a summary.

    Raises:
        InputError: There is none.
    """
    try:
        summary = json.loads(read_text(path, LARGEST_SUMMARY_BYTES, FIGURES))
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(path, "", f"no JSON ({error})", FIGURES) from error
    if not isinstance(summary, dict) or "words_completed" not in summary:
        raise InputError(path, "", "no summary", FIGURES)
    return summary


def tell(bag: Bag, course: Course, verdict: Verdict) -> str:
    """How complete a bag is, and how far its run is judged."""
    dropped = sum(bag.dropped.values())
    lines = [f"{sum(bag.counts.values()):,} messages on {len(bag.counts)} topics, {dropped} dropped"]
    if course.missing:
        lines.append(f"{course.missing} events are missing")
    if course.restarts:
        lines.append(f"the world was started again {course.restarts} times")
    if course.start is not None and course.start.time > 0.0:
        lines.append(f"the bag begins at {course.start.time:g} s")
    for name, count in sorted(course.senseless.items()):
        lines.append(f"{count} messages on {name} make no sense and are left out")
    lines += [f"{name} is of another version and left out" for name in course.foreign]
    if verdict.why:
        lines.append(verdict.why)
    return "; ".join(lines)


def compare(console: Console, ours: dict[str, Any], theirs: dict[str, Any]) -> int:
    """Tell where the figures differ; 1 if counted ones do."""
    found = differences(ours, theirs)
    counted = sum(is_counted for *_, is_counted in found)
    if found:
        shown = Table("figure", "bag", "summary", "", title="Differences", title_justify="left")
        for key, value, other, is_counted in found:
            how = "" if is_counted else "measured from places in the bag"
            shown.add_row(known(key).words, str(value), str(other), how)
        console.print(shown)
    console.print(f"{len(ours) - len(found)} figures are equal, {counted} counted ones differ", highlight=False)
    return 1 if counted else 0


if __name__ == "__main__":
    sys.exit(main())
