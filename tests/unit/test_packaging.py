"""The package list of pyproject.toml and the folders of the repository say the same."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("reference_impl", "analyzer", "vectors", "conformance")


def _project() -> dict[str, object]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_every_folder_with_code_is_installed() -> None:
    tool = _project()["tool"]
    assert isinstance(tool, dict)
    listed = set(tool["setuptools"]["packages"])
    found = {
        ".".join(("snhc", *init.parent.relative_to(ROOT).parts))
        for room in ROOMS
        for init in (ROOT / room).rglob("__init__.py")
    }
    assert listed == found


def test_every_room_is_marked_as_typed() -> None:
    for room in ROOMS:
        assert (ROOT / room / "py.typed").is_file()


def test_every_folder_is_mapped_below_the_distribution_name() -> None:
    tool = _project()["tool"]
    assert isinstance(tool, dict)
    mapping = tool["setuptools"]["package-dir"]
    assert mapping == {f"snhc.{room}": room for room in ROOMS}


def test_what_users_need_beside_the_code_is_installed() -> None:
    import snhc.conformance

    folder = Path(snhc.conformance.__file__).parent
    for name in (
        "c/snhc_decoder.h", "adapters/adapter.schema.json", "adapters/protocol.schema.json", "doctor.schema.json",
        "isolation/warden.py",
    ):  # fmt: skip
        assert (folder / name).is_file(), name
