"""Code and register agree: public code of the codec names its rules, and every built rule has code.

Rules: CNF-8.

A docstring names rules in a sentence `Rules: FBA-6..8, FBA-37.`; methods and properties stand under the rules of
their class. A rule counts as coded if such a sentence of a function, class or method names it, or if a string in the
code is exactly its id (`Element("frame_rate", "FBA-6", ...)`). Module docstrings are announcements and do not count,
nor do the rooms that only hold data.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from snhc.reference_impl import rules as register

ROOT = Path(__file__).parents[2]
ROOMS = ("reference_impl", "analyzer", "vectors", "conformance")
DATA_ROOMS = ("reference_impl/rules/", "reference_impl/tables/")
_AREA = "|".join(register.AREAS)
_SENTENCE = re.compile(r"\bRules:\s*(.*?)(?:\.(?=\s|$)|\n\s*\n|$)", re.DOTALL)
_ID = re.compile(rf"(?<!AMB-)\b({_AREA})-(\d+)(?:\.\.(?:(?:{_AREA})-)?(\d+))?")
_REPORTERS = ("Finding", "finding", "note")
_FINDING = re.compile(r"[a-z]+(-[a-z0-9]+)+")

Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def ids_in(text: str) -> set[str]:
    """Rule ids in a text, ranges expanded."""
    return {
        f"{area}-{number}"
        for area, first, last in _ID.findall(text)
        for number in range(int(first), int(last or first) + 1)
    }


def rules_of(node: Definition) -> set[str]:
    """Rule ids in the `Rules:` sentences of a docstring."""
    return {rule for sentence in _SENTENCE.findall(ast.get_docstring(node) or "") for rule in ids_in(sentence)}


def public_definitions(tree: ast.Module) -> list[Definition]:
    """Public functions and classes of a module, also those inside module-level `if` and `try`."""
    out: list[Definition] = []
    blocks: list[ast.stmt] = list(tree.body)
    while blocks:
        node = blocks.pop(0)
        if isinstance(node, Definition):
            if not node.name.startswith("_"):
                out.append(node)
        elif isinstance(node, ast.If | ast.Try):
            blocks[:0] = [child for child in ast.iter_child_nodes(node) if isinstance(child, ast.stmt)]
    return out


def lint(file: str, source: str, known: set[str]) -> list[str]:
    """Complaints about one module of the codec, `file:line: what is wrong`."""
    out = []
    for node in public_definitions(ast.parse(source)):
        named = rules_of(node)
        if not named:
            out.append(f"{file}:{node.lineno}: {node.name} names no rule (Rules: FBA-26. in its docstring)")
    for number, line in enumerate(source.splitlines(), 1):
        out += [f"{file}:{number}: {rule} is not in the register" for rule in sorted(ids_in(line) - known)]
    return out


def coded(source: str) -> set[str]:
    """Rules that a module codes."""
    out: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, Definition):
            out |= rules_of(node)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _ID.fullmatch(node.value):
            out |= ids_in(node.value)
    return out


def findings_in(source: str) -> set[str]:
    """Finding ids in calls like `io.finding("no-stuffing", ...)`."""
    out: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            first = node.args[0].value
            if name in _REPORTERS and isinstance(first, str) and _FINDING.fullmatch(first):
                out.add(first)
    return out


def sources(*rooms: str) -> dict[str, str]:
    """Path from the root -> text of every Python file of the rooms."""
    files = sorted(path for room in rooms for path in (ROOT / room).rglob("*.py"))
    assert files, "no source files found: the test must run in the checkout"
    return {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in files}


def test_public_code_of_the_codec_names_rules_of_the_register() -> None:
    known = set(register.rules())
    complaints = [line for file, text in sources("reference_impl").items() for line in lint(file, text, known)]
    assert not complaints, "\n" + "\n".join(complaints)


def test_every_built_rule_is_named_by_code() -> None:
    code = {file: text for file, text in sources(*ROOMS).items() if not file.startswith(DATA_ROOMS)}
    named = {rule for text in code.values() for rule in coded(text)}
    missing = [entry.id for entry in register.rules().values() if entry.built and entry.id not in named]
    assert not missing, f"\nrules marked built that no code names ({len(missing)}): " + ", ".join(missing)


def test_readings_of_built_ambiguities_are_named_by_code() -> None:
    texts = "\n".join(text for file, text in sources(*ROOMS).items() if not file.startswith(DATA_ROOMS))
    built = [entry.id for entry in register.ambiguities().values() if entry.built]
    missing = [name for name in built if not re.search(rf"{name}\b", texts)]
    assert not missing, "\nambiguities marked built that no code names: " + ", ".join(missing)


def test_findings_that_code_reports_are_registered() -> None:
    unknown = [
        f"{file}: {name}"
        for file, text in sources(*ROOMS).items()
        for name in sorted(findings_in(text) - set(register.findings()))
    ]
    assert not unknown, "\nfindings that the register does not hold:\n" + "\n".join(unknown)


def test_findings_in_calls() -> None:
    source = 'io.finding("a-b", 1)\nFinding("c-d")\nfinding(name)\nlog("e-f")\nnote("Some text")\n'
    assert findings_in(source) == {"a-b", "c-d"}


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("FBA-6..8, FBA-37", {"FBA-6", "FBA-7", "FBA-8", "FBA-37"}),
        ("FBA-6..FBA-8", {"FBA-6", "FBA-7", "FBA-8"}),
        ("AMB-FBA-6 and CNF-7.", {"CNF-7"}),
        ("14496-2, FBA-EX-1, DCT-II", set()),
    ],
)
def test_ids_in_text(text: str, ids: set[str]) -> None:
    assert ids_in(text) == ids


@pytest.mark.parametrize(
    ("source", "complaints"),
    [
        ('def f():\n    """Effect.\n\n    Rules: FBA-1."""', []),
        ('def f():\n    """Effect. Rules: FBA-1, FBA-2."""', []),
        ('def f():\n    """Effect (FBA-1)."""', ["m.py:1: f names no rule"]),
        ("def f(): ...", ["m.py:1: f names no rule"]),
        ("def _f(): ...", []),
        ("if A:\n    class C: ...", ["m.py:2: C names no rule"]),
        ('class C:\n    """Rules: FBA-1."""\n    def method(self): ...', []),
        ('def f():\n    """Rules: FBA-1, FBA-777."""', ["m.py:2: FBA-777 is not in the register"]),
        ("# a comment (CNF-99)", ["m.py:1: CNF-99 is not in the register"]),
    ],
)
def test_the_lint_itself(source: str, complaints: list[str]) -> None:
    found = lint("m.py", source, set(register.rules()))
    assert len(found) == len(complaints)
    assert all(line.startswith(start) for line, start in zip(found, complaints, strict=True))


def test_what_counts_as_coded() -> None:
    source = '"""Rules: FBA-1."""\nE = Element("frame_rate", "FBA-6")\ndef _f():\n    """See FBA-9. Rules: FBA-7."""\n'
    assert coded(source) == {"FBA-6", "FBA-7"}
