"""The report of a sweep: one HTML file that needs nothing else, with all that it takes to repeat the sweep."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Sequence
from html import escape

from soup_lab.experiments.analysis import Analysis, Row
from soup_lab.experiments.charts import bars, curve, curve_key, differences
from soup_lab.experiments.experiment import Group
from soup_lab.experiments.identity import versions
from soup_lab.experiments.table import HEADERS, LEGEND, cells, difference_text, mark
from soup_msgs_py.figures import Figure, known, told

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2126; max-width: 1240px; margin: 2em auto; padding: 0 1.2em; }
h1, h2 { line-height: 1.25; } h2 { margin-top: 2.2em; }
table { border-collapse: collapse; font-size: 13.5px; font-variant-numeric: tabular-nums; }
.wide { overflow-x: auto; }
th, td { padding: 3px 9px; text-align: right; border-bottom: 1px solid #dfe3e8; white-space: nowrap; }
th { white-space: normal; vertical-align: bottom; border-bottom: 2px solid #3d4852; font-weight: 600; }
th:first-child, td:first-child { text-align: left; }
tr.base td { background: #eef1f4; font-weight: 600; }
tr.better td:nth-child(3) { color: #1b7f5c; } tr.worse td:nth-child(3) { color: #b3401f; }
.broken { color: #b3001f; font-weight: 600; }
img { max-width: 100%; display: block; margin: 1em 0; }
pre { background: #f5f6f8; padding: 0.8em 1em; overflow-x: auto; font-size: 12.5px; line-height: 1.4; }
.note { color: #56616c; font-size: 13.5px; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 1.2em; } dd { margin: 0; }
summary { cursor: pointer; }
"""
RUN_KEYS = (
    "words_per_second", "fraction_of_bound", "words_completed", "letters_in_words", "distance_total_m", "pile_on_word",
    "pile_on_letter", "bot_collisions", "bucket_collisions", "violations", "bot_idle_fraction",
    "word_station_idle_fraction", "letter_station_idle_fraction", "inventory_fill_start", "inventory_fill_end",
    "bots", "real_time_factor", "wall_seconds",
)  # fmt: skip


def report(analysis: Analysis) -> str:
    """The whole page. The same sweep gives the same page, but for wall times."""
    experiment = analysis.experiment
    parts = [
        f"<h1>{escape(experiment.name)}</h1>",
        f"<p>{escape(experiment.about)}</p>" if experiment.about else "",
        _what_was_run(analysis),
        _failures(analysis),
        _overview(analysis),
        *(_group(group, rows) for group, rows in analysis.groups),
        _how_to_read(analysis),
        _all_runs(analysis),
        _to_repeat(analysis),
    ]
    head = f'<meta charset="utf-8"><title>{escape(experiment.name)}</title><style>{STYLE}</style>'
    body = "\n".join(filter(None, parts))
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def _what_was_run(analysis: Analysis) -> str:
    experiment, plan = analysis.experiment, analysis.experiment.base.plan
    scenario = plan.warehouse.scenario
    facts = {
        "base": f"policies {analysis.base.case.name} on scenario {scenario.name}: {scenario.bots} bots, "
        f"{scenario.buckets} buckets, {scenario.word_station_count} word and "
        f"{scenario.letter_station_count} letter stations",
        "a run": f"{plan.duration_s:g} simulated seconds, of which the first {plan.warmup_s:g} are not counted",
        "seeds": f"{', '.join(map(str, experiment.seeds))}, the same for all variants",
        "violations": f"{analysis.violations:,} broken laws of the warehouse in all runs",
    }
    return f"<dl>{''.join(f'<dt>{escape(key)}</dt><dd>{escape(text)}</dd>' for key, text in facts.items())}</dl>"


def _failures(analysis: Analysis) -> str:
    lines = [
        f"<li>{escape(row.case.label)}, seed {seed}: {escape(failure.reason)}</li>"
        for row in analysis.rows()
        for seed, failure in row.failures.items()
    ]
    return f'<h2 class="broken">Runs that failed</h2><ul>{"".join(lines)}</ul>' if lines else ""


def _overview(analysis: Analysis) -> str:
    """All variants against the base in one chart, where there is more than one group."""
    rows = [
        (f"{group.name}: {row.case.name}", row)
        for group, rows in analysis.groups
        for row in rows
        if row.difference is not None
    ]
    if len(analysis.groups) < 2 or not rows:
        return ""
    listed = "; ".join(f"{label} {difference_text(row.difference)}" for label, row in rows if row.difference)
    return f"<h2>What matters</h2>{_image(differences(rows), f'Differences to the base in words/s: {listed}')}"


def _group(group: Group, rows: Sequence[Row]) -> str:
    there = [row for row in rows if row.summaries]
    chart = ""
    if there:
        key = curve_key(there)
        drawn = bars(there) if key is None else curve(there, key)
        rates = "; ".join(f"{row.case.name} {cells(row)[1]}" for row in there)
        chart = _image(drawn, f"Words/s in the group {group.name}: {rates}")
    about = f"<p>{escape(group.about)}</p>" if group.about else ""
    return f"<h2>{escape(group.name)}</h2>{about}{chart}{_table(HEADERS, map(_cells, rows), map(_kind, rows))}"


def _cells(row: Row) -> list[str]:
    texts = [escape(text) for text in cells(row)]
    for place, keys in ((7, ("bot_collisions", "bucket_collisions")), (8, ("violations",))):
        if row.summaries and any(row.totals[key] for key in keys):
            texts[place] = f'<span class="broken">{texts[place]}</span>'
    return texts


def _kind(row: Row) -> str:
    if row.is_base:
        return "base"
    marked = mark(row.difference) if row.difference is not None else ""
    return {"": "", "▲": "better", "▼": "worse"}[marked[:1]]


def _how_to_read(analysis: Analysis) -> str:
    return (
        f'<h2>How to read it</h2><p class="note">{escape(LEGEND)} {analysis.comparisons} variants were compared with '
        "the base. All variants meet the same orders, words and places at the start with the same seed, so most of "
        "the noise is the same in both and leaves the difference. Collisions and violations are sums over all seeds. "
        "m/letter: metres that all bots drove, per letter of a finished word. The real-time factor is that of "
        "runs side by side, the loading of compiled code included. Bars: dots are single runs.</p>"
    )


def _all_runs(analysis: Analysis) -> str:
    lines = [
        [escape(row.case.label), str(seed), *(told(key, summary[key]) for key in RUN_KEYS)]
        for row in analysis.rows()
        for seed, summary in row.summaries.items()
    ]
    headers = ("run", "seed", *(_header(known(key)) for key in RUN_KEYS))
    return f"<h2>All runs</h2><details><summary>{len(lines)} runs</summary>{_table(headers, lines)}</details>"


def _header(figure: Figure) -> str:
    return f"{figure.words}, {figure.unit}" if figure.unit else figure.words


def _to_repeat(analysis: Analysis) -> str:
    """The text of all files, the choices as they were resolved, the versions."""
    experiment = analysis.experiment
    first = next(iter(experiment.texts))
    command = f"python3 scripts/compare_policies.py {first} --replications {len(experiment.seeds)}"
    known = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in versions().items())
    files = [_folded(name, text, name == first) for name, text in experiment.texts.items()]
    for row in analysis.rows():
        policies = json.dumps(row.case.plan.policies.model_dump(mode="json"), indent=1)
        changed = f"scenario: {json.dumps(row.case.changed)}\n" if row.case.changed else ""
        files.append(_folded(f"policies of {row.case.label}", changed + policies))
    return f"<h2>To repeat it</h2><pre>{escape(command)}</pre><dl>{known}</dl>{''.join(files)}"


def _folded(title: str, text: str, is_open: bool = False) -> str:
    start = "<details open>" if is_open else "<details>"
    return f"{start}<summary>{escape(title)}</summary><pre>{escape(text)}</pre></details>"


def _table(headers: Sequence[str], rows: Iterable[Sequence[str]], kinds: Iterable[str] | None = None) -> str:
    """Rows of cells that are HTML already."""
    head = "".join(f'<th scope="col">{escape(header)}</th>' for header in headers)
    body = [list(row) for row in rows]
    classes = list(kinds) if kinds is not None else [""] * len(body)
    lines = (
        f'<tr class="{kind}">{"".join(f"<td>{cell}</td>" for cell in row)}</tr>'
        for row, kind in zip(body, classes, strict=True)
    )
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>'


def _image(svg: str, description: str) -> str:
    data = base64.b64encode(svg.encode()).decode()
    return f'<img alt="{escape(description)}" src="data:image/svg+xml;base64,{data}">'
