"""The program behind `scripts/make_reference.py`: `docs/reference`, written from the models that the code works by."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from soup_lab.lab_arguments import parse_reference
from soup_lab.reference.policies import policies_page
from soup_lab.reference.scenario import scenario_page
from soup_managers.explain import ALTERNATIVES, DECISIONS
from soup_msgs_py.figures import FIGURES, LIVE_FIGURES, PLAN_FIGURES, SHARE, Figure
from soup_msgs_py.routing import HEARERS

NOTE = "<!-- Written by scripts/make_reference.py from the code; change it there. -->\n\n"
COMMAND = "python3 scripts/make_reference.py"


def figures_page() -> str:
    """What the keys of a summary mean."""
    lines = [
        "# Figures",
        "",
        "The keys of a summary (`--summary FILE`) and their words in the table on the screen. They are the same for",
        "headless runs, live runs and bags. Counts and rates cover the time after `--warmup`. A share is a number from",
        "0 to 1 in the file, and in percent on the screen.",
        "",
        *_figures_table(FIGURES),
        "",
        "A live world also publishes on `/world/statistics`:",
        "",
        *_figures_table(LIVE_FIGURES),
        "",
        "With `--replications N` each figure is a mean; `interval_95` holds half the width of its 95 % interval, and",
        "`replications` the summaries of the single runs.",
        "",
        "The summary of `scripts/plan_world.py`, which also has `plans`, the letters of each robot:",
        "",
        *_figures_table(PLAN_FIGURES),
    ]
    return "\n".join(lines) + "\n"


def explain_page() -> str:
    """What a line of `--explain` means."""
    lines = [
        "# Explain lines",
        "",
        "`--explain FILE` writes one line of JSON for each decision:",
        "",
        "| key | meaning |",
        "|---|---|",
        "| `time` | simulated time (s) |",
        "| `decision` | which decision; see below |",
        "| `station`, `tile`, `bot`, `bucket`, `spot` | what it is for: a number of the warehouse |",
        "| `tile_name` | the tile as letter and colour, for instance `E0` |",
        "| `chosen` | the number of what was chosen; -1: nothing |",
        "| `name` | for a word its letters, for a tile kind its letter and colour |",
        f"| `alternatives` | the best {ALTERNATIVES}, best first: `choice`, `name` where there is one, `score` |",
        "",
        "The best alternative is not always chosen: a bucket may be out of reach just then.",
        "Alternatives with score 0 are left out.",
        "",
        "| `decision` | `chosen` | told with | `score` |",
        "|---|---|---|---|",
    ]
    for name, decision in DECISIONS.items():
        about = ", ".join(f"`{key}`" for key in decision.about)
        lines.append(f"| `{name}` | {decision.chosen} | {about} | {decision.score} |")
    return "\n".join(lines) + "\n"


def messages_page() -> str:
    """Which message goes to whom, and what it carries."""
    lines = [
        "# Messages",
        "",
        "What the parts of a warehouse say to each other, in one process as over ROS, by the routing table",
        "(`soup_msgs_py/routing.py`). Which topic, service or action carries it live, and who says it, is in",
        "[architecture](../architecture.md).",
        "",
        "| message | who hears it | what it says | fields |",
        "|---|---|---|---|",
    ]
    for message, hearer in HEARERS.items():
        about = (message.__doc__ or "").strip().splitlines()[0]
        names = ", ".join(f"`{name}`" for name in message.__annotations__)
        lines.append(f"| `{message.__name__}` | {hearer.value} | {about} | {names} |")
    return "\n".join(lines) + "\n"


def _figures_table(figures: dict[str, Figure]) -> list[str]:
    rows = [
        f"| `{key}` | {figure.words} | {'share' if figure.unit == SHARE else figure.unit} | {figure.meaning} |"
        for key, figure in figures.items()
    ]
    return ["| key | on the screen | unit | meaning |", "|---|---|---|---|", *rows]


PAGES = {
    "scenario.md": scenario_page,
    "figures.md": figures_page,
    "policies.md": policies_page,
    "explain.md": explain_page,
    "messages.md": messages_page,
}


def outdated(folder: Path) -> list[str]:
    """The documents in a folder that are not what the code says."""
    return [name for name, page in PAGES.items() if _read(folder / name) != NOTE + page()]


def main(argv: Sequence[str] | None = None, *, folder: Path) -> int:
    """Write the documents into a folder, or with `--check` only look at them; the exit status."""
    options = parse_reference(argv, folder)
    names = outdated(folder)
    if options.check:
        for name in names:
            print(
                f"{folder / name}: found a text that differs from the code; write it again with {COMMAND}",
                file=sys.stderr,
            )
        return 1 if names else 0
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).write_text(NOTE + PAGES[name](), encoding="utf-8")
        print(f"wrote {folder / name}")
    return 0


def _read(file: Path) -> str:
    return file.read_text(encoding="utf-8") if file.is_file() else ""
