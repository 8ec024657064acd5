"""The rows of a sweep as text: one table for the screen, the report and a README."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from soup_lab.experiments.analysis import Analysis, Row
from soup_lab.experiments.statistics import Difference, Estimate
from soup_msgs_py.figures import SHARE, with_interval, written

HEADERS = (
    "variant", "words/s", "to base, words/s", "of bound (worst seed), %", "pile-on word, tiles/visit",
    "pile-on letter, tiles/visit", "m/letter", "collisions bot, bucket", "violations", "stock end/start, %",
    "real-time factor",
)  # fmt: skip
NOTHING = "–"
LEGEND = (
    "words/s: mean ± half the 95 % interval over the seeds. To base: mean paired difference, seed by seed, with its "
    "95 % interval; ▲ ▼ it excludes 0, ▲▲ ▼▼ also with all comparisons of the sweep taken together (Holm)."
)


def cells(row: Row) -> list[str]:
    """A row as text, one cell a header."""
    figures, totals = row.figures, row.totals
    name = f"{row.case.name} (base)" if row.is_base else row.case.name
    if row.failures:
        name += f" ({len(row.failures)} of {len(row.failures) + len(row.summaries)} runs failed)"
    if not row.summaries:
        return [name, *[NOTHING] * (len(HEADERS) - 1)]
    return [
        name,
        _with_interval(figures["words_per_second"]),
        difference_text(row.difference),
        _bound(figures["fraction_of_bound"]),
        _mean(figures["pile_on_word"]),
        _mean(figures["pile_on_letter"]),
        _mean(figures["metres_per_letter"]),
        f"{totals['bot_collisions']:,}, {totals['bucket_collisions']:,}",
        f"{totals['violations']:,}",
        _mean(figures["inventory_end_to_start"], SHARE),
        _mean(figures["real_time_factor"]),
    ]


def screen(analysis: Analysis, wide: bool = True) -> Table:
    """All groups in one table for the screen; where it is not wide, cells are broken into lines."""
    seeds = ", ".join(map(str, analysis.experiment.seeds))
    title = f"{analysis.experiment.name}: seeds {seeds}"
    table = Table(title=title, title_justify="left", caption=LEGEND, caption_justify="left")
    for place, header in enumerate(HEADERS):
        longest = max(map(len, header.split()))
        justify = "left" if place == 0 else "right"
        table.add_column(header, justify=justify, min_width=longest if wide else None, no_wrap=wide and place < 4)
    for group, rows in analysis.groups:
        table.add_row(f"[bold]{escape(group.name)}[/bold]", *[""] * (len(HEADERS) - 1))
        for number, row in enumerate(rows):
            name, *others = map(escape, cells(row))
            table.add_row(f"  {name}", *others, end_section=number == len(rows) - 1)
    return table


def markdown(analysis: Analysis) -> str:
    """All groups in one table for a README; without what depends on the machine."""
    headers = ("decision", *HEADERS[:-1])
    lines = [f"| {' | '.join(headers)} |", f"|{'---|' * 2}{'---:|' * (len(headers) - 2)}"]
    for group, rows in analysis.groups:
        for number, row in enumerate(rows):
            texts = ["" if number else group.name, *cells(row)[:-1]]
            lines.append(f"| {' | '.join(text.replace('|', chr(92) + '|') for text in texts)} |")
    return "\n".join([*lines, "", LEGEND, ""])


def difference_text(difference: Difference | None) -> str:
    """A difference with its interval, its share of the base and its mark."""
    if difference is None:
        return NOTHING
    found = difference.estimate
    text = f"{'+' if found.mean > 0.0 else ''}{with_interval(found.mean, found.half_width)}"
    if difference.share is not None:
        text += f" ({difference.share:+.1%})"
    return " ".join(filter(None, [text, mark(difference)]))


def mark(difference: Difference) -> str:
    """How sure it is, and which way it goes."""
    if not difference.significant:
        return ""
    return ("▲" if difference.estimate.mean > 0.0 else "▼") * (2 if difference.family else 1)


def _with_interval(figure: Estimate | None) -> str:
    return NOTHING if figure is None else with_interval(figure.mean, figure.half_width)


def _mean(figure: Estimate | None, unit: str = "") -> str:
    return NOTHING if figure is None else written(figure.mean, unit)


def _bound(figure: Estimate | None) -> str:
    return NOTHING if figure is None else f"{written(figure.mean, SHARE)} ({written(figure.lowest, SHARE)})"
