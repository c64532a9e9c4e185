"""Pages that are made from the register and the suite when the documentation is built.

One page per area with all its rules, the ambiguities, the findings, all vectors by group. They are written into
`docs/generated`, which is not kept in the repository: the register and the manifest are the only sources.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.rules import AREAS, CONFIDENCES, Rule, ambiguities, findings, rules
from snhc.vectors import catalogue
from snhc.vectors.manifest import Entry, load

AREA_TITLES: Final = {
    "FBA": "Face animation streams", "DCT": "The DCT mode", "MSH": "2D meshes", "FIT": "FAP interpolation tables",
    "FAT": "Face animation tables", "FAC": "The face model", "SYS": "Systems: headers, profiles, files, scenes",
    "TTS": "Speech", "CNF": "Vectors, adapters, reports",
}  # fmt: skip
CONFIDENCE_WORDS: Final = {
    "paper": "printed in one of the papers",
    "confirmed": "two independent public witnesses agree",
    "strong memory": "recalled from the standard and structurally verified",
    "memory": "recalled only",
    "derived": "follows from others",
    "one implementation": "so done by one implementation and seen nowhere else",
    "this suite": "undefined in our sources; our own definition",
}
# Rule ids become links, but not where they stand inside another id (AMB-FBA-6).
_ID: Final = re.compile(r"(?<![\w-])(AMB-)?(" + "|".join(AREAS) + r")-([1-9]\d*)\b")
_NAMED: Final = re.compile(r"(?<![\w-])(" + "|".join(AREAS) + r")-([1-9]\d*)(?:\.\.(\d+))?")
_SHOWN: Final = 12


def write_pages(folder: Path) -> None:
    """Write all pages into a folder; what is there already and not made now is removed."""
    pages = {
        "rules.md": _index(), "ambiguities.md": _ambiguities(), "findings.md": _findings(), "fuzzing.inc": _fuzzing(),
    }  # fmt: skip
    vectors = _vectors()
    places = _places()
    for area in AREAS:
        pages[f"rules-{area}.md"] = _area(area, vectors, places)
    pages |= _catalogue()
    folder.mkdir(exist_ok=True)
    for path in folder.glob("*.md"):
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        # An unchanged page keeps its time, so that Sphinx does not read it again.
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _linked(text: str, here: str = "") -> str:
    """The text with links to rules and ambiguities."""

    def link(match: re.Match[str]) -> str:
        id = match[0]
        known = id in ambiguities() if match[1] else id in rules()
        if id == here or not known:
            return id
        page = "ambiguities.md" if match[1] else f"rules-{match[2]}.md"
        return f"[{id}]({page}#{_anchor(id)})"

    return _ID.sub(link, _plain(text))


def _plain(text: str) -> str:
    """Text of the register as text of a page: no markup of its own."""
    return re.sub(r"([\\`*_\[\]<>|])", r"\\\1", " ".join(text.split()))


def _anchor(id: str) -> str:
    return id.lower()


def _index() -> str:
    lines = ["# Rules", "", "Every fact that the decoder rests on is a rule with a permanent id. Code, traces, errors,"]
    lines += ["vectors and reports name the rule that they follow.", "", "| area | rules | built |", "|---|---|---|"]
    for area in AREAS:
        of = [rule for rule in rules().values() if rule.id.startswith(f"{area}-")]
        lines.append(
            f"| [{area}: {AREA_TITLES[area]}](rules-{area}.md) | {len(of)} | {sum(rule.built for rule in of)} |"
        )
    lines += ["", "How sure we are of a rule:", "", "| confidence | meaning | rules |", "|---|---|---|"]
    for word in CONFIDENCES:
        count = sum(rule.confidence == word for rule in rules().values())
        lines.append(f"| {word} | {CONFIDENCE_WORDS[word]} | {count} |")
    lines += ["", "Numbers of clauses of the standard are from memory and unverified.", ""]
    lines += ["```{toctree}", ":hidden:", "", *(f"rules-{area}" for area in AREAS), "```", ""]
    return "\n".join(lines)


def _area(area: str, vectors: dict[str, list[Entry]], places: dict[str, list[str]]) -> str:
    lines = [f"# {area}: {AREA_TITLES[area]}", ""]
    for rule in rules().values():
        if rule.id.startswith(f"{area}-"):
            lines += _rule(rule, vectors.get(rule.id, []), places.get(rule.id, []))
    return "\n".join(lines) + "\n"


def _rule(rule: Rule, vectors: list[Entry], places: list[str]) -> Iterator[str]:
    yield f"({_anchor(rule.id)})="
    yield f"## {rule.id} {_plain(rule.title)}"
    yield ""
    yield _linked(rule.statement, rule.id)
    yield ""
    note = f" ({_linked(rule.note, rule.id)})" if rule.note else ""
    yield f"Confidence\n: {rule.confidence}: {CONFIDENCE_WORDS[rule.confidence]}{note}."
    yield ""
    if rule.clause:
        yield f"Clause (unverified)\n: {_plain(rule.clause)}\n"
    if rule.ambiguities:
        yield "Ambiguities\n: " + ", ".join(f"[{id}](ambiguities.md#{_anchor(id)})" for id in rule.ambiguities) + "\n"
    if not rule.built:
        yield "Built\n: not yet\n"
    elif places:
        yield "Code\n: " + ", ".join(f"`{place}`" for place in places) + "\n"
    if vectors:
        shown = ", ".join(_vector(entry.id) for entry in vectors[:_SHOWN])
        more = f" and {len(vectors) - _SHOWN} more" if len(vectors) > _SHOWN else ""
        yield f"Vectors ({len(vectors)})\n: {shown}{more}: `snhc run --filter rule={rule.id}`\n"


def _ambiguities() -> str:
    lines = [
        "# Ambiguities", "",
        "Where our sources leave two or more readings open, one is followed and the others can be chosen where the",
        "decoder has a switch: `--reading ID=KEY`. Reports say which reading a decoder follows.", "",
    ]  # fmt: skip
    vectors: dict[str, list[str]] = defaultdict(list)
    for entry in load(check_schema=False).entries:
        for id in entry.readings:
            vectors[id].append(entry.id)
    for entry in ambiguities().values():
        lines += [f"({_anchor(entry.id)})=", f"## {entry.id}", "", _linked(entry.question, entry.id), ""]
        for key, words in entry.readings.items():
            mark = " **(followed)**" if key == entry.followed else ""
            lines += [f"`{key}`{mark}\n: {_linked(words, entry.id)}", ""]
        lines += [f"Why\n: {_linked(entry.why, entry.id)}", ""]
        lines += ["Rules\n: " + ", ".join(_linked(id) for id in entry.rules), ""]
        lines += ["Switch\n: " + ("yes" if entry.built else "none yet"), ""]
        if vectors[entry.id]:
            lines += ["Vectors that tell the readings apart\n: " + ", ".join(map(_vector, vectors[entry.id])), ""]
    return "\n".join(lines)


def _manner(campaign: dict[str, Any]) -> str:
    how = "guided" if campaign["guided"] else "unguided"
    return how + ", address sanitizer" if campaign["sanitizer"] else how


def _fuzzing() -> str:
    """The campaigns on record, the newest first: `tests/fuzz/last.json`."""
    record = Path(__file__).parents[1] / "tests" / "fuzz" / "last.json"
    if not record.exists():
        return "No campaign is on record.\n"
    campaigns = json.loads(record.read_text(encoding="utf-8"))
    lines = [
        "## What was run", "", "| form | how | campaigns | inputs | findings | slowest, of what an input may take |",
        "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for form, how in dict.fromkeys((one["form"], _manner(one)) for one in campaigns):
        same = [one for one in campaigns if (one["form"], _manner(one)) == (form, how)]
        targets = [target for one in same for target in one["targets"]]
        worst = max(10 * target.get("ratio", 0) for target in targets)
        lines.append(
            f"| {form} | {how} | {len(same)} | {sum(one['inputs'] for one in same):,} "
            f"| {sum(1 for target in targets if target.get('finding'))} | {worst:.1f} % |"
        )
    lines.append("")
    for campaign in reversed(campaigns):
        at = f", at commit {campaign['commit']}" if campaign.get("commit") else ""
        lines += [
            f"### {campaign['date']}: {campaign['form']} form, {_manner(campaign)}", "",
            f"{campaign['inputs']:,} inputs in {campaign['seconds']:,} s on {campaign['cores']} cores{at}.", "",
            "| target | inputs | long ones | slowest, ms | of what it may take | peak memory, MB | finding |",
            "|---|---|---|---|---|---|---|",
        ]  # fmt: skip
        for one in campaign["targets"]:
            share = f"{10 * one.get('ratio', 0):.1f} %"
            finding = _plain(one.get("finding", "")) or "none"
            counts = f"{one['inputs']:,} | {one.get('pumped', 0):,}"
            cost = f"{one.get('slowest_ms', 0)} | {share} | {one.get('peak_mb', 'not measured')}"
            lines.append(f"| {one['target']} | {counts} | {cost} | {finding} |")
        lines.append("")
    return "\n".join(lines)


def _findings() -> str:
    lines = [
        "# Findings", "", "What is accepted but wrong or odd. `decode` prints findings on standard error, `check` on",
        "standard output, `dump` where they stand.", "", "| id | severity | rule | what it says |", "|---|---|---|---|",
    ]  # fmt: skip
    lines += [
        f"| `{kind.id}` | {kind.severity} | {_linked(kind.rule)} | {_linked(kind.description)} |"
        for kind in findings().values()
    ]
    return "\n".join(lines) + "\n"


def _catalogue() -> dict[str, str]:
    """An overview and one page per group of vectors."""
    manifest = load(check_schema=False)
    groups = catalogue.groups(manifest)
    lines = [
        "# Vectors", "", f"The suite, version {manifest.suite}: {len(manifest.entries)} vectors. What the fields mean:",
        "[](../suite.md).", "", catalogue.overview(manifest, {group: _group_page(group) for group in groups}),
        "```{toctree}", ":hidden:", "", *(_group_page(group).removesuffix(".md") for group in groups), "```", "",
    ]  # fmt: skip
    pages = {"vectors.md": "\n".join(lines)}
    for group, entries in groups.items():
        pages[_group_page(group)] = catalogue.page(group, entries, _linked)
    return pages


def _group_page(group: str) -> str:
    return f"vectors-{group.replace('.', '-')}.md"


def _vector(id: str) -> str:
    return f"[`{id}`]({_group_page(catalogue.group_of(id))}#{catalogue.anchor(id)})"


def _vectors() -> dict[str, list[Entry]]:
    out: dict[str, list[Entry]] = defaultdict(list)
    for entry in load(check_schema=False).entries:
        for id in entry.rules:
            out[id].append(entry)
    return out


def _places() -> dict[str, list[str]]:
    """Rule -> the modules of the package that name it, by the `Rules:` of their docstrings and their elements."""
    out: dict[str, list[str]] = defaultdict(list)
    spec = find_spec("snhc.reference_impl")
    assert spec is not None
    assert spec.submodule_search_locations
    top = Path(next(iter(spec.submodule_search_locations)))
    for room in ("reference_impl", "analyzer", "vectors", "conformance"):
        folder = top.parent / room if room != "reference_impl" else top
        for path in sorted(folder.rglob("*.py")):
            name = ".".join(path.relative_to(folder).with_suffix("").parts).removesuffix(".__init__")
            if name.startswith("recipes"):
                continue
            named: set[str] = set()
            for match in _NAMED.finditer(path.read_text(encoding="utf-8")):
                last = int(match[3] or match[2])
                named |= {f"{match[1]}-{n}" for n in range(int(match[2]), last + 1)}
            for id in named:
                out[id].append(f"{room}.{name}")
    return out
