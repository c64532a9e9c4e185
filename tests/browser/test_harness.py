"""The harness itself: a script's fault must be seen."""

from __future__ import annotations

from pathlib import Path

from conftest import Page


def test_a_fault_of_a_script_is_seen(page: Page, tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    file.write_text("<!doctype html><title>t</title><script>document.title = 'ran'; nowhere.x = 1</script>")
    assert page.open(file).title == "ran"
    (said,) = page.errors()
    assert "nowhere is not defined" in said
    assert page.shot("page").read_bytes().startswith(b"\x89PNG")
