"""The suite as a folder for people who never install Python, or as one archive of it.

Rules: CNF-3, CNF-4, CNF-5. Everything comes from the suite on disk, held against its manifest; the same suite always
gives the same bytes. A folder is left whole or not at all.

    SHA256SUMS              of all other files, for `sha256sum -c`
    README.md               how to judge a decoder by hand
    VECTORS.md, RULES.md    what the vectors show; the rules and ambiguities that they name
    manifest.json, manifest.schema.json, LICENSE, and the vectors' files
"""

from __future__ import annotations

import errno
import gzip
import os
import shutil
import tarfile
from collections.abc import Iterable
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from string import Template
from typing import Final

from snhc.reference_impl.rules import ambiguities, rules

from .catalogue import listing, overview
from .manifest import MANIFEST_NAME, SCHEMA_FILE, SUITE, Manifest, load, read_files

SUMS: Final = "SHA256SUMS"
ARCHIVE: Final = ".tar.gz"
_LICENCE: Final = Path(__file__).parent / "LICENSE"
_README: Final = Path(__file__).parent / "export_readme.md"


def export_files(suite: Path = SUITE) -> dict[str, bytes]:
    """All files of an export by name. Rules: CNF-3.

    Raises InputFormat for a suite whose manifest or files are not as they should be.
    """
    manifest = load(suite)
    files = {MANIFEST_NAME: (suite / MANIFEST_NAME).read_bytes()}
    for entry in manifest.entries:
        files |= read_files(entry, suite)
    files[SCHEMA_FILE.name] = SCHEMA_FILE.read_bytes()
    files["README.md"] = _readme(manifest).encode()
    files["VECTORS.md"] = f"# Vectors of suite {manifest.suite}\n\n{overview(manifest)}\n{listing(manifest)}".encode()
    files["RULES.md"] = _rules(manifest).encode()
    files["LICENSE"] = _LICENCE.read_bytes()
    files = dict(sorted(files.items()))
    sums = "".join(f"{sha256(content).hexdigest()}  {name}\n" for name, content in files.items())
    return {**files, SUMS: sums.encode()}


def _readme(manifest: Manifest) -> str:
    kinds = {kind: sum(entry.kind == kind for entry in manifest.entries) for kind in ("valid", "invalid", "ambiguous")}
    tools = sorted({tool for entry in manifest.entries for tool in entry.tools})
    text = Template(_README.read_text(encoding="utf-8"))
    return text.substitute(
        suite=manifest.suite, count=len(manifest.entries), tools=", ".join(f"`{tool}`" for tool in tools),
        overview=overview(manifest), **kinds,
    )  # fmt: skip


def _rules(manifest: Manifest) -> str:
    named = {rule for entry in manifest.entries for rule in entry.rules}
    known = rules()
    lines = [
        "# Rules that the vectors name", "",
        "In this project's own words; the text of the standard is not here. *confidence*: what the rule rests on.", "",
    ]  # fmt: skip
    for rule in known.values():
        if rule.id in named:
            note = f"; {rule.note}" if rule.note else ""
            lines += [f"## {rule.id}: {rule.title}", "", rule.statement.strip(), "", f"*{rule.confidence}{note}*", ""]
    lines += ["# Ambiguities", "", "Questions that the standard leaves open. The reading in bold is followed.", ""]
    used = {amb for entry in manifest.entries for amb in entry.readings}
    for amb in ambiguities().values():
        if amb.id in used:
            lines += [f"## {amb.id}: {amb.question}", ""]
            lines += [
                f"* **`{key}`**: {text}" if key == amb.followed else f"* `{key}`: {text}"
                for key, text in amb.readings.items()
            ]
            lines += ["", f"Why: {amb.why}", ""]
    return "\n".join(lines)


def write_export(target: Path, suite: Path = SUITE) -> dict[str, bytes]:
    """Write an export to a folder. Rules: CNF-3, CNF-4.

    An empty folder, or an older export in which nothing else lies, is replaced; FileExistsError for any other.
    """
    files = export_files(suite)
    # A link stays a link: what it points to is replaced.
    target = target.resolve()
    if target.exists() and not _replaceable(target):
        raise FileExistsError(errno.EEXIST, "neither empty nor an export alone", str(target))
    fresh = target.with_name(f".{target.name[:200]}.{os.getpid()}.part")
    old = target.with_name(f".{target.name[:200]}.{os.getpid()}.old")
    try:
        for name, content in files.items():
            path = fresh / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        if target.exists():
            target.rename(old)
        fresh.rename(target)
    except BaseException:
        shutil.rmtree(fresh, ignore_errors=True)
        if old.exists() and not target.exists():
            old.rename(target)
        raise
    if old.exists():
        shutil.rmtree(old)
    return files


def _replaceable(folder: Path) -> bool:
    """Whether a folder is empty, or holds what the checksums in it name and nothing else."""
    if not folder.is_dir():
        return False
    there = {
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir() or path.is_symlink()
    }
    if not there:
        return not any(folder.iterdir())
    if SUMS not in there or MANIFEST_NAME not in there:
        return False
    lines = (folder / SUMS).read_text(encoding="utf-8", errors="replace").splitlines()
    return there <= {line[66:] for line in lines} | {SUMS}


def archive(files: dict[str, bytes], top: str) -> bytes:
    """The files as .tar.gz below one folder: no owner, no time, one order. Rules: CNF-4.

    The tar inside is the same everywhere; how well it is packed hangs on the version of zlib.
    """
    packed = BytesIO()
    # Named None and stamped 0: the header of gzip tells nothing of this machine.
    with gzip.GzipFile(None, "wb", 9, packed, mtime=0) as zipped:
        zipped.write(_tar(files, top))
    return packed.getvalue()


def _tar(files: dict[str, bytes], top: str) -> bytes:
    out = BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.PAX_FORMAT) as tar:
        for name in _folders(top, files):
            folder = tarfile.TarInfo(name)
            folder.type, folder.mode = tarfile.DIRTYPE, 0o755
            tar.addfile(folder)
        for name, content in sorted(files.items()):
            member = tarfile.TarInfo(f"{top}/{name}")
            member.size, member.mode = len(content), 0o644
            tar.addfile(member, BytesIO(content))
    return out.getvalue()


def _folders(top: str, names: Iterable[str]) -> list[str]:
    return [top, *sorted({f"{top}/{name.rpartition('/')[0]}" for name in names if "/" in name})]
