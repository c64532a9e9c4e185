"""The vectors of a suite as pages for people: an overview, one page per group, one section per vector.

Rules: CNF-3, CNF-4, CNF-5. Markdown, made from the manifest alone. A group is the first word of the ids; those of FAPs
go on to the second (`fap.arith`, `fap.dct`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Final

from .manifest import TIERS, Accepted, Entry, Expect, Manifest

_GROUPS: Final[Mapping[str, str]] = {
    "fap.arith": "FAPs, arithmetic coding",
    "fap.dct": "FAPs, DCT coding",
    "fap": "FAPs: masks, ranges, values, states",
    "fba": "Face and body objects: framing, headers, bodies",
    "sys": "Visual object headers, profiles, levels",
    "dct": "DCT coefficients",
    "mesh": "2D meshes",
    "fit": "FAP interpolation tables",
    "fat": "Face animation tables",
    "fapu": "FAP units",
}
_TIERS: Final = {
    "syntax": "tiny, one feature each",
    "semantic": "what the values mean",
    "stress": "the largest and the longest",
    "error": "one named fault each",
    "real": "realistic sequences",
    "profile": "profiles and levels",
}


def group_of(id: str) -> str:
    """`fap.arith` of `fap.arith.example.1`, `mesh` of `mesh.example.1`. Rules: CNF-3."""
    first, _, rest = id.partition(".")
    second = rest.partition(".")[0]
    return f"{first}.{second}" if f"{first}.{second}" in _GROUPS else first


def group_title(group: str) -> str:
    """What a group is about; the group itself where nothing is known of it. Rules: CNF-3."""
    return _GROUPS.get(group, group)


def groups(manifest: Manifest) -> dict[str, list[Entry]]:
    """The vectors by group, groups in the order of this module, then by name. Rules: CNF-3."""
    order = {group: i for i, group in enumerate(_GROUPS)}
    found: dict[str, list[Entry]] = {}
    for entry in manifest.entries:
        found.setdefault(group_of(entry.id), []).append(entry)
    return dict(sorted(found.items(), key=lambda item: (order.get(item[0], len(order)), item[0])))


def overview(manifest: Manifest, links: Mapping[str, str] | None = None) -> str:
    """A table: groups by tiers, how many vectors. Rules: CNF-5. `links`: group -> where its page is."""
    tiers = [tier for tier in TIERS if any(entry.tier == tier for entry in manifest.entries)]
    lines = [
        "| group | about | " + " | ".join(tiers) + " | all |", "|---|---|" + "---:|" * (len(tiers) + 1),
    ]  # fmt: skip
    for group, entries in groups(manifest).items():
        counts = Counter(entry.tier for entry in entries)
        name = f"[`{group}`]({links[group]})" if links else f"`{group}`"
        cells = [str(counts[tier]) if counts[tier] else "" for tier in tiers]
        lines.append(f"| {name} | {group_title(group)} | " + " | ".join(cells) + f" | {len(entries)} |")
    counts = Counter(entry.tier for entry in manifest.entries)
    total = " | ".join(str(counts[tier]) for tier in tiers)
    lines.append(f"| all | | {total} | {len(manifest.entries)} |")
    lines += ["", *(f"* `{tier}`: {_TIERS[tier]}" for tier in tiers)]
    return "\n".join(lines) + "\n"


def listing(manifest: Manifest) -> str:
    """All vectors in tables, one per group: id, title, tier, kind, rules. Rules: CNF-3."""
    out = []
    for group, entries in groups(manifest).items():
        out += [f"## {group_title(group)}", "", "| id | title | tier | kind | rules |", "|---|---|---|---|---|"]
        for entry in entries:
            rules = " ".join(entry.rules)
            out.append(f"| `{entry.id}` | {_cell(entry.title)} | {entry.tier} | {entry.kind} | {rules} |")
        out.append("")
    return "\n".join(out)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")


def anchor(id: str) -> str:
    """Where a vector stands on its page. Rules: CNF-3."""
    return f"vector-{id}"


def section(entry: Entry, link: Callable[[str], str] = str) -> str:
    """One vector in full, under a heading of level 3 with an anchor before it. Rules: CNF-3. `link`: of rules."""
    lines = [f"({anchor(entry.id)})=", f"### `{entry.id}`", "", f"**{_escaped(entry.title)}**", ""]
    lines += [_escaped(entry.description), ""]
    facts = [
        ("tier, kind", f"{entry.tier}, {entry.kind}"),
        ("tools", _words(entry.tools)),
        ("profile", entry.profile or ""),
        ("rules", ", ".join(link(rule) for rule in entry.rules)),
        ("features", _words(entry.features)),
        ("value classes", _words(entry.value_classes)),
        ("options", ", ".join(f"`{key}`: {value}" for key, value in entry.options.as_json().items())),
        ("input", f"`{entry.file}`" + (f" on `{entry.aux}`" if entry.aux else "")),
        ("expected", _expect(entry.expect)),
    ]
    for amb, readings in entry.readings.items():
        facts += [(f"{link(amb)} = {key}", _expect(expect)) for key, expect in readings.items()]
    if entry.tolerance is not None:
        facts.append(("tolerance", f"{entry.tolerance.model}, {entry.tolerance.bound!r}"))
    if entry.check is not None:
        found = ", ".join(f"`{finding['id']}`" for finding in entry.check["findings"]) or "no findings"
        held = entry.check["profile"] or "no known profile"
        facts.append(("check", f"{held}: {entry.check['verdict']}; {found}"))
    facts += [("notes", _escaped(entry.notes)), ("since", entry.since)]
    lines += [f"* {name}: {text}" for name, text in facts if text]
    return "\n".join(lines) + "\n"


def _escaped(text: str) -> str:
    # Titles and docstrings are plain sentences with `code`; nothing else of Markdown is meant.
    return text.replace("<", "\\<").replace("*", "\\*").replace("$", "\\$").replace("[", "\\[")


def _words(words: Iterable[str]) -> str:
    return ", ".join(f"`{word}`" for word in words)


def _expect(expect: Expect) -> str:
    if isinstance(expect, Accepted):
        return f"`{expect.file}`"
    allowed = "" if expect.allowed == ("reject",) else f"; allowed: {', '.join(expect.allowed)}"
    return f"{expect.error_class} ({expect.rule}) at {expect.place}{allowed}"


def page(group: str, entries: Iterable[Entry], link: Callable[[str], str] = str) -> str:
    """The page of a group, tier by tier. Rules: CNF-3, CNF-5. `link`: as in `section`."""
    known = list(entries)
    lines = [f"# {group_title(group)}", "", f"Vectors `{group}.*`: {len(known)}.", ""]
    for tier in TIERS:
        chosen = [entry for entry in known if entry.tier == tier]
        if chosen:
            lines += [f"## {tier}: {_TIERS[tier]}", "", *(section(entry, link) for entry in chosen)]
    return "\n".join(lines)
