"""Queries: what they take, and what is no query."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from snhc.analyzer.dump import TreeOptions, dump_tree
from snhc.analyzer.parts import Parts
from snhc.analyzer.query import FIELDS, Query, QueryError, Subject
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import trace_stream

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
STREAM = (SAMPLES / "fba" / "fba-11-00003" / "input.fba").read_bytes()


def taken(expression: str, data: bytes = STREAM, symbols: bool = False) -> list[str]:
    options = TreeOptions(symbols=symbols)
    lines = list(dump_tree(Parts(trace_stream(data)), BytesSource(data), options, Query(expression)))
    return [line for line in lines[1:] if line.startswith("[")]


def values(expression: str) -> set[tuple[str, int, str, str, int]]:
    """(name, value, rule, path, start) of the rows that an expression takes."""
    query, source = Query(expression), BytesSource(STREAM)
    return {
        (part.trace.el(row).name, part.trace.value[row], part.trace.el(row).rule, part.trace.path_text(row), start)
        for part in Parts(trace_stream(STREAM))
        for row, start in enumerate(part.trace.start)
        if query.takes_row(part, row, source)
    }


ALL = values("true")


def test_the_examples_of_the_documentation() -> None:
    assert values('name == "fap_quant" && value > 0') == {row for row in ALL if row[0] == "fap_quant" and row[1] > 0}
    assert values('rule == "FBA-16"') == {row for row in ALL if row[2] == "FBA-16"}
    long = [part.plane for part in Parts(trace_stream(STREAM)) if part.plane is not None]
    assert len(taken('kind == "plane" && bits > 600')) == sum(plane.end - plane.start > 600 for plane in long) > 0


def test_every_name_can_be_asked_for() -> None:
    part = list(Parts(trace_stream(STREAM)))[1]
    for name, field in FIELDS.items():
        for row in (-1, 0):
            made = field.get(Subject(part, row, BytesSource(STREAM)))
            wanted = {"string": str, "int": int, "bool": bool, "double": float, "list of int": list}[field.type]
            assert type(made) is wanted, name


def test_symbols_are_asked_only_where_they_are_traced() -> None:
    expression = 'kind == "symbol" && name.startsWith("FAP 3 ") && value > 0'
    assert taken(expression) == []
    found = taken(expression, symbols=True)
    assert found
    assert all("FAP 3 open_jaw = " in line for line in found)


def test_lists_and_regular_expressions() -> None:
    assert taken("levels.exists(level, level > 100)")
    assert len(values('path.matches("group.[12].$") && name == "marker_bit"')) == 4


@pytest.mark.parametrize(
    ("expression", "column", "said"),
    [
        ("name ==", 8, "EOF"),
        ("nme == 'x'", 1, "did you mean name?"),
        ("kind == 'nme' && nme == 'x'", 18, "did you mean name?"),
        ("value > 'x'", 1, "No such overload"),
        ("value", 1, "not int"),
        ("", 1, "an expression"),
        ("name.__class__ == 1", 1, "computed"),
        ("open('x') == 1", 1, "a function of the language"),
        ("[1].all(a, [2].all(b, b > a))", 15, "at most one of"),
        ("(" * 500 + "1" + ")" * 500, 97, "nested too deeply"),
        ("true && " * 300 + "true", 2001, "at most 2000 characters"),
    ],
)
def test_what_is_no_query_is_refused_at_its_place(expression: str, column: int, said: str) -> None:
    with pytest.raises(QueryError) as caught:
        Query(expression)
    assert (caught.value.line, caught.value.column) == (1, column)
    assert said in str(caught.value)
    assert caught.value.exit_code == 2


def test_a_division_by_zero_says_where() -> None:
    with pytest.raises(QueryError, match="no division by zero, as at bits"):
        values("10 / value > 1")


def test_hostile_regular_expressions_take_no_time() -> None:
    began = time.process_time()
    values('raw.matches("(0+)+(1+)+(0+)+2")')
    assert time.process_time() - began < 20


def test_the_page_of_the_language_has_every_name_as_it_is() -> None:
    page = (Path(__file__).parents[2] / "docs" / "query.md").read_text(encoding="utf-8")
    for name, field in FIELDS.items():
        assert f"| `{name}` | {field.type} | {field.text.replace('``', 'empty')} |" in page
