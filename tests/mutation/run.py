# ruff: noqa: T201
"""The mutation tester (cosmic-ray) over the decoder's core, on a copy of the checkout.

    python tests/mutation/run.py [--sample N] [--seed S] [--report FILE] [--keep]

Every operator of cosmic-ray on every place of the files in CORE; of all mutations a sample is tried, the same for the
same seed. The copy has the package `snhc` as folders, before the installed one in the path, in the pure form: the
checkout itself is not touched. Prints the score and the survivors; `--report` writes them as JSON.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("reference_impl", "analyzer", "vectors", "conformance")
CORE = (
    "entropy/kernel.py", "entropy/model.py", "entropy/prefix.py", "face/reconstruct.py", "face/state.py",
    "mesh/motion.py", "interpolation/fit.py", "interpolation/fit_table.py",
)  # fmt: skip
# Annotations and texts of errors are no behaviour of the decoder.
OPERATORS_OUT = ("core/RemoveDecorator", "core/ExceptionReplacer")
SECONDS = 120.0


def copy_of(checkout: Path, target: Path) -> None:
    for room in ROOMS:
        shutil.copytree(
            checkout / room, target / "snhc" / room, ignore=shutil.ignore_patterns("__pycache__", "*.so", "examples")
        )
    shutil.copytree(checkout / "tests", target / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(checkout / "pyproject.toml", target)


def mutations(target: Path, sample: int, seed: int, session: Path) -> int:
    """Make the session: all mutations known, a sample to be tried. Returns how many there are in all."""
    from cosmic_ray.commands import init
    from cosmic_ray.work_db import WorkDB, use_db
    from cosmic_ray.work_item import WorkerOutcome, WorkResult

    with use_db(str(session), WorkDB.Mode.create) as db:
        files = [target / "snhc" / "reference_impl" / name for name in CORE]
        init(files, db, {})
        items = sorted(db.work_items, key=lambda item: _place(item))
        items = [item for item in items if _counts(item, target)]
        chosen = {item.job_id for item in random.Random(seed).sample(items, min(sample, len(items)))}
        for item in list(db.work_items):
            if item.job_id not in chosen:
                db.set_result(item.job_id, WorkResult(worker_outcome=WorkerOutcome.SKIPPED))
        return len(items)


def _place(item: Any) -> tuple[Any, ...]:
    mutation = item.mutations[0]
    return str(mutation.module_path), mutation.start_pos, mutation.operator_name, mutation.occurrence


def _counts(item: Any, target: Path) -> bool:
    mutation = item.mutations[0]
    if mutation.operator_name.startswith(OPERATORS_OUT):
        return False
    line = Path(mutation.module_path).read_text(encoding="utf-8").splitlines()[mutation.start_pos[0] - 1].strip()
    # `int | None` in an annotation is no arithmetic.
    return not (line.startswith(("def ", ") ->", "from ", "import ")) or (": " in line and " | None" in line))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=250)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--report", type=Path)
    parser.add_argument("--keep", action="store_true", help="keep the copy, and say where it is")
    given = parser.parse_args()
    target = Path(tempfile.mkdtemp(prefix="snhc-mutation-"))
    try:
        return _run(given, target)
    finally:
        if given.keep:
            print(f"kept: {target}")
        else:
            shutil.rmtree(target)


def _run(given: argparse.Namespace, target: Path) -> int:
    copy_of(ROOT, target)
    environment = {
        **os.environ, "PYTHONPATH": str(target), "SNHC_PURE": "1", "PYTHONDONTWRITEBYTECODE": "1",
        "OPENBLAS_NUM_THREADS": "1",
    }  # fmt: skip
    judge = [sys.executable, str(target / "tests" / "mutation" / "judge.py")]
    # Without any mutation nobody may notice anything.
    if subprocess.run(judge, env=environment, cwd=target, check=False).returncode:
        print("the copy does not pass without any mutation")
        return 2
    session = target / "session.sqlite"
    total = mutations(target, given.sample, given.seed, session)
    config = target / "cosmic-ray.toml"
    config.write_text(
        "[cosmic-ray]\n"
        f'module-path = "{target / "snhc" / "reference_impl"}"\ntimeout = {SECONDS}\nexcluded-modules = []\n'
        f'test-command = "{sys.executable} {target}/tests/mutation/judge.py"\n'
        '[cosmic-ray.distributor]\nname = "local"\n',
        encoding="utf-8",
    )
    subprocess.run(
        [sys.executable, "-m", "cosmic_ray.cli", "exec", str(config), str(session)],
        env=environment, cwd=target, check=True,
    )  # fmt: skip
    report = _report(target, session, total, given)
    text = json.dumps(report, indent=1) + "\n"
    if given.report is not None:
        given.report.write_text(text, encoding="utf-8")
    print(f"{report['killed']} of {report['tried']} killed ({report['score']}), of {total} mutations in all")
    for one in report["survivors"]:
        print(f"{one['file']}:{one['line']}: {one['operator']}: {one['change']}")
    return 0


def _report(target: Path, session: Path, total: int, given: argparse.Namespace) -> dict[str, Any]:
    from cosmic_ray.work_db import WorkDB, use_db

    counts: dict[str, int] = {}
    survivors: list[dict[str, Any]] = []
    by_file: dict[str, list[int]] = {}
    with use_db(str(session), WorkDB.Mode.open) as db:
        items = {item.job_id: item for item in db.work_items}
        for job, result in db.results:
            outcome = result.test_outcome.value if result.test_outcome is not None else result.worker_outcome.value
            if outcome == "skipped":
                continue
            counts[outcome] = counts.get(outcome, 0) + 1
            mutation = items[job].mutations[0]
            name = Path(mutation.module_path).relative_to(target / "snhc" / "reference_impl").as_posix()
            by_file.setdefault(name, [0, 0])
            by_file[name][1] += 1
            by_file[name][0] += outcome == "killed"
            if outcome == "survived":
                survivors.append(
                    {
                        "file": name, "line": mutation.start_pos[0], "operator": mutation.operator_name,
                        "change": _change(result.diff or ""),
                    }
                )  # fmt: skip
    tried = counts.get("killed", 0) + counts.get("survived", 0)
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "python": platform.python_version(),
        "tool": f"cosmic-ray {_version()}",
        "mutations": total,
        "sample": given.sample,
        "seed": given.seed,
        "tried": tried,
        "killed": counts.get("killed", 0),
        "score": f"{100 * counts.get('killed', 0) / max(tried, 1):.1f} %",
        "other": {name: count for name, count in sorted(counts.items()) if name not in ("killed", "survived")},
        "files": {name: {"killed": killed, "tried": all_} for name, (killed, all_) in sorted(by_file.items())},
        "survivors": sorted(survivors, key=lambda one: (one["file"], one["line"], one["operator"])),
    }


def _version() -> str:
    from importlib.metadata import version

    return version("cosmic-ray")


def _change(diff: str) -> str:
    lines = [line for line in diff.splitlines() if line[:1] in "+-" and line[:3] not in ("+++", "---")]
    return " => ".join(line[1:].strip() for line in lines)


if __name__ == "__main__":
    sys.exit(main())
