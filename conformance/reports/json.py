"""A report as JSON, and back.

Rules: CNF-18, CNF-20, CNF-25. The form is `report.schema.json`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from snhc.conformance.results import Report
from snhc.reference_impl.bitstream.errors import InputFormat, cause

SCHEMA_FILE: Final = Path(__file__).parent / "report.schema.json"


def text(report: Report) -> str:
    """The JSON report. Rules: CNF-18."""
    return json.dumps(report.as_json(), ensure_ascii=False, indent=1) + "\n"


def load(path: Path) -> Report:
    """A saved report. Rules: CNF-18, CNF-25. Raises InputFormat with the path of the first misfit, OSError."""
    import jsonschema

    try:
        document = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise InputFormat("CNF-18", str(path), value=cause(error), allowed="a JSON report of `snhc run`") from error
    schema = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))
    for misfit in jsonschema.Draft202012Validator(schema).iter_errors(document):
        raise InputFormat(
            "CNF-18", f"{path}: {misfit.json_path}", value=misfit.message[:300], allowed="what the report schema says",
            path=misfit.json_path,
        )  # fmt: skip
    return Report.from_json(document)
