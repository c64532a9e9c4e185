"""The kill matrix as one HTML file that needs no network.

Rules: CNF-8, CNF-18.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Final

from snhc.analyzer.pages import base_css

from .matrix import HOW, Line, Matrix
from .text import TOPIC_NAMES, WAYS

_STYLE: Final = """
body { margin: 2rem auto; max-width: 78rem; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
table { width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .35rem .6rem; border-bottom: 1px solid var(--line); }
th { font-weight: 600; } td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
code { font-size: .88em; overflow-wrap: anywhere; }
small { color: var(--soft); } details > summary { cursor: pointer; }
.killed { color: var(--good); } .told { color: var(--warn); } .survives { color: var(--bad); }
input { font: inherit; padding: .35rem .6rem; width: 24rem; max-width: 100%; margin: .6rem 0; }
.c1 { width: 46%; } .c2 { width: 10rem; }
"""
_SCRIPT: Final = """
const box = document.querySelector('input');
box.addEventListener('input', () => {
  const words = box.value.toLowerCase().split(/\\s+/).filter(Boolean);
  for (const row of document.querySelectorAll('tr[data-text]'))
    row.hidden = !words.every(word => row.dataset.text.includes(word));
  for (const part of document.querySelectorAll('section.topic'))
    part.hidden = !part.querySelector('tr[data-text]:not([hidden])');
});
"""


def page(matrix: Matrix) -> Iterator[str]:
    """The file, piece by piece. Rules: CNF-8."""
    yield "<!doctype html>\n<html lang='en'>\n<meta charset='utf-8'>\n"
    yield "<meta name='viewport' content='width=device-width, initial-scale=1'>\n<title>snhc kill matrix</title>\n"
    yield f"<style>{base_css()}{_STYLE}</style>\n<h1>Kill matrix of suite {escape(matrix.suite)}</h1>\n"
    yield (
        f"<p>{len(matrix.lines)} mistakes of implementers, put into the reference decoder one at a time, against "
        f"{len(matrix.vectors)} vectors. <b class='killed'>Killed</b>: a vector fails. <b class='told'>Told apart</b>: "
        "every vector passes, and the report says in which of the allowed ways. <b class='survives'>Survives</b>: no "
        "vector shows it, for the reason given.</p>\n"
    )
    yield from _summary(matrix)
    yield "<p><input type='search' placeholder='Words to look for: ids, rules, vectors' aria-label='filter'></p>\n"
    for topic in dict.fromkeys(line.topic for line in matrix.lines):
        name = TOPIC_NAMES.get(topic, topic)
        yield f"<section class='topic'><h2>{escape(name[0].upper() + name[1:])}</h2>\n<table>"
        yield "<tr><th class='c1'>mistake<th class='c2'>rules<th>vectors\n"
        for line in matrix.lines:
            if line.topic == topic:
                yield _row(line)
        yield "</table></section>\n"
    yield from _vectors(matrix)
    yield f"<script>{_SCRIPT}</script>\n</html>\n"


def _summary(matrix: Matrix) -> Iterator[str]:
    heads = "".join(f"<th class='n'>{head}" for head in ("all", "killed", "told apart", "survive"))
    yield f"<table><tr><th>mutants of{heads}\n"
    topics = list(dict.fromkeys(line.topic for line in matrix.lines))
    for topic in [*topics, ""]:
        lines = [line for line in matrix.lines if topic in ("", line.topic)]
        killed = sum(line.killed for line in lines)
        shown = sum(bool(line.kills) for line in lines)
        cells = "".join(f"<td class='n'>{n}" for n in (len(lines), killed, shown - killed, len(lines) - shown))
        yield f"<tr><td>{escape(TOPIC_NAMES.get(topic, topic) or 'all')}{cells}\n"
    yield "</table>\n"


def _row(line: Line) -> str:
    kind = "killed" if line.killed else "told" if line.kills else "survives"
    changes = "".join(f"<br><small><code>{escape(change)}</code></small>" for change in line.change)
    words = " ".join((line.id, line.title, *line.rules, *line.killers)).lower()
    if line.kills:
        ways = "; ".join(f"{WAYS[how]}: {len(line.kills[how])}" for how in HOW if how in line.kills)
        found = (
            f"<details><summary><span class='{kind}'>{len(line.killers)}</span>, first "
            f"<code>{escape(line.first)}</code> "
            f"<small>{escape(ways)}</small></summary><code>{'<br>'.join(map(escape, line.killers))}</code></details>"
        )
    else:
        found = f"<span class='{kind}'>none</span>: {escape(line.survives or 'no reason given')}"
    return (
        f"<tr data-text='{escape(words, quote=True)}'><td>{escape(line.title)}<br><code "
        f"class='{kind}'>{escape(line.id)}"
        f"</code>{changes}<td>{escape(', '.join(line.rules))}<td>{found}\n"
    )


def _vectors(matrix: Matrix) -> Iterator[str]:
    columns = matrix.columns()
    yield "<section><h2>Vectors</h2>\n"
    if not matrix.complete:
        yield "<p>Each mutant was tried only up to its first killer: nothing can be said of vectors.</p></section>\n"
        return
    alone = matrix.alone()
    lists = (
        ("enough", "vectors are enough to show every mutant that any shows", matrix.enough()),
        ("alone", "vectors are the only ones that show some mutant", tuple(alone)),
        ("redundant", "vectors show no mutant that others do not show too", matrix.redundant()),
        ("idle", "vectors show no mutant", tuple(vector for vector, mutants in columns.items() if not mutants)),
    )
    for _, words, vectors in lists:
        yield f"<details><summary>{len(vectors)} {words}</summary><table>"
        for vector in vectors:
            mutants = alone.get(vector) or columns[vector]
            shown = ", ".join(map(escape, mutants[:8])) + (f" and {len(mutants) - 8} more" if len(mutants) > 8 else "")
            yield f"<tr><td><code>{escape(vector)}</code><td><code>{shown}</code>\n"
        yield "</table></details>\n"
    yield "</section>\n"
