"""A fuzzing campaign over all targets: `python tests/fuzz/campaign.py --runs 200000`.

Inputs are shared out by the targets' shares; targets run side by side, each in a process of its own. Prints a table;
`--results FILE` adds it to a JSON file of campaigns, which the documentation shows. Ends with 1 where something was
found, and says where the input lies.

`--plain`: without atheris, for the compiled form and the address sanitizer (see `one`).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE)]


def _one(name: str, runs: int, folder: Path, plain: bool, seed: int, seconds: int) -> dict[str, Any]:
    report = folder / f"{name}.json"
    words = [
        sys.executable, str(HERE / "one.py"), name, f"-runs={runs}", f"--report={report}", f"--seed={seed}",
        f"-artifact_prefix={folder / name}-", *(["--plain"] if plain else ["-timeout=60", "-rss_limit_mb=2048"]),
    ]  # fmt: skip
    if not plain:
        words.append(f"-max_total_time={seconds}")
    with (folder / f"{name}.txt").open("wb") as said:
        # The fuzzer ends its process without a word to Python: what it leaves lies where all goes at the end.
        environment = {**os.environ, "TMPDIR": str(folder)}
        code = subprocess.run(words, stdout=said, stderr=subprocess.STDOUT, check=False, env=environment).returncode
    text = (folder / f"{name}.txt").read_text(encoding="utf-8", errors="replace")
    found: dict[str, Any] = json.loads(report.read_text()) if report.exists() else {"target": name, "inputs": 0}
    done = re.search(r"Done (\d+) (?:runs )?in", text)
    if done is not None:
        found["inputs"] = int(done[1])
    if not plain and not code and " cov: " not in text:
        found["finding"] = "no guidance: the package is not instrumented (is it compiled?)"
    if code:
        inputs = [path.name for path in folder.glob(f"{name}-*")]
        found["finding"] = found.get("finding") or f"ended with {code}"
        found["input"] = str(folder / inputs[0]) if inputs else ""
        print(text[-3_000:], file=sys.stderr)  # noqa: T201
    return found


def _commit() -> str:
    """The state of the sources that the campaign ran on, `+` where files were changed; empty outside a checkout."""
    told = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--dirty=+", "--exclude=*"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return told.stdout.strip() if not told.returncode else ""


def main() -> int:
    from targets import TARGETS

    from snhc.conformance.cli.version import version_line

    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=200_000, help="inputs over all targets")
    parser.add_argument("--plain", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=int, default=1_500, help="at most, for each target")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", nargs="*", default=list(TARGETS), choices=list(TARGETS), metavar="TARGET")
    parser.add_argument("--results", type=Path)
    options = parser.parse_args()
    targets = [TARGETS[name] for name in options.only]
    whole = sum(target.share for target in targets)
    folder = Path(tempfile.mkdtemp(prefix="snhc-fuzz-"))
    started = time.monotonic()
    with ThreadPoolExecutor(options.jobs) as pool:
        # The dearest first, so that no core waits for it at the end.
        waiting = [
            pool.submit(
                _one, target.name, max(1, options.runs * target.share // whole), folder, options.plain, options.seed,
                options.seconds,
            )
            for target in sorted(targets, key=lambda target: not target.streams)
        ]  # fmt: skip
        found = sorted((future.result() for future in waiting), key=lambda one: list(TARGETS).index(one["target"]))
    seconds = round(time.monotonic() - started)
    inputs = sum(one["inputs"] for one in found)
    for one in found:
        print(  # noqa: T201
            f"{one['target']:<12} {one['inputs']:>9} inputs  slowest {one.get('slowest_ms', 0):>7} ms  "
            f"{one.get('ratio', 0):>5} of a valid input's time  {one.get('finding') or 'no finding'}"
        )
    bad = [one for one in found if one.get("finding")]
    form = version_line()
    print(f"{form}: {inputs} inputs in {seconds} s, {len(bad)} findings")  # noqa: T201
    for one in bad:
        print(f"finding: {one['target']}: {one['finding']} ({one.get('input') or 'no input kept'})")  # noqa: T201
    if options.results is not None:
        old = json.loads(options.results.read_text()) if options.results.exists() else []
        for one in found:
            one.pop("input", None)
        old.append({
            "date": datetime.now(UTC).date().isoformat(), "form": form.rpartition("(")[2].rstrip(")"),
            "commit": _commit(), "guided": not options.plain, "inputs": inputs, "seconds": seconds,
            "cores": os.cpu_count(), "sanitizer": "asan" in os.environ.get("LD_PRELOAD", ""), "targets": found,
        })  # fmt: skip
        options.results.write_text(json.dumps(old, indent=1) + "\n")
    if not bad:
        shutil.rmtree(folder)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
