"""The HTML report in a browser: filters, failures, themes, keyboard, hostile decoders.

Rules: CNF-18.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from conftest import Page
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

from snhc.conformance.adapters import BuiltIn, OneShot
from snhc.conformance.filters import selector
from snhc.conformance.reports import render
from snhc.conformance.runner import run
from snhc.vectors.manifest import load

HARNESS = Path(__file__).parent.parent / "harness"
SELECTION = "fap.arith.example.*|fap.arith.model.adapts|fba.error.time-code.*|mesh.delaunay.c*"
NAME = "<script>document.title='owned'</script>"
# Moves a node and turns a triangle of a mesh; says hostile words.
WRONG = """
import json, sys
from pathlib import Path
from snhc.vectors.decoding import decode
from snhc.reference_impl.systems.stream import Options

decoded = decode(Path(sys.argv[1]).read_bytes(), Options())
for line in decoded.lines:
    frame = json.loads(line)
    if len(frame.get("nodes", [])) > 3:
        frame["nodes"][3][0] += 40
    print(json.dumps(frame))
if decoded.error is not None:
    sys.stderr.write(json.dumps({"class": "<script>document.title='owned'</script>"}) + "\\n")
    sys.stderr.write("<img src=x onerror=\\"document.title='owned'\\"> <b>bold</b>\\n")
    sys.exit(1)
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    script = folder / "wrong.py"
    script.write_text(WRONG)
    adapters = [
        OneShot(NAME, (sys.executable, str(script), "{input}"), tools=("fba", "mesh")),
        OneShot("wrong value", (sys.executable, str(HARNESS / "wrong_value.py"), "{input}")),
        BuiltIn(),
    ]  # fmt: skip
    report = run(load(check_schema=False), adapters, select=selector(SELECTION), filter=SELECTION, jobs=2)
    path = folder / "report.html"
    path.write_text(render(report, "html"))
    return path


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Some vectors fail, some do not."""
    adapters = [OneShot("wrong value", (sys.executable, str(HARNESS / "wrong_value.py"), "{input}")), BuiltIn()]
    report = run(load(check_schema=False), adapters, select=selector(SELECTION), filter=SELECTION, jobs=2)
    path = tmp_path_factory.mktemp("mixed") / "report.html"
    path.write_text(render(report, "html"))
    return path


def shown(page: Page) -> list[str]:
    rows = page.browser.find_elements(By.CSS_SELECTOR, ".matrix tbody tr")
    return [row.find_element(By.CSS_SELECTOR, ".id").text for row in rows if row.is_displayed()]


def choose(page: Page, field: str, value: str) -> None:
    Select(page.browser.find_element(By.ID, field)).select_by_value(value)


def count(page: Page) -> str:
    return page.browser.find_element(By.ID, "f-count").text


def test_filters_and_a_failure(page: Page, file: Path) -> None:
    browser = page.open(file)
    everything = shown(page)
    assert len(everything) > 10 and count(page) == f"{len(everything)} of {len(everything)} vectors"

    choose(page, "f-tool", "mesh")
    assert shown(page) and all(id.startswith("mesh.") for id in shown(page))
    browser.find_element(By.CSS_SELECTOR, "#filters button").click()
    choose(page, "f-tier", "error")
    assert shown(page) and all(".error." in id for id in shown(page))
    choose(page, "f-tier", "")
    choose(page, "f-rule", "FBA-25")
    assert "fap.arith.example.2" in shown(page) and "fap.arith.example.4" not in shown(page)
    choose(page, "f-rule", "")
    choose(page, "f-adapter", "1")
    choose(page, "f-status", "fail")
    failing = shown(page)
    assert failing and all(id.startswith("fap.arith.") for id in failing)
    choose(page, "f-adapter", "2")
    assert shown(page) == [] and count(page) == f"0 of {len(everything)} vectors"
    browser.find_element(By.CSS_SELECTOR, "#filters button").click()
    browser.find_element(By.ID, "f-text").send_keys("guard in an INTRA")
    assert shown(page) == ["fap.arith.example.2"]
    page.shot("filtered")

    browser.find_element(By.CSS_SELECTOR, ".matrix tbody tr:not([hidden]) td:nth-of-type(4) a").click()
    article = browser.find_element(By.CSS_SELECTOR, ".failure:target")
    assert article.is_displayed() and not browser.find_element(By.ID, "overview").is_displayed()
    text = article.text
    assert "fap.arith.example.2" in text and "wrong value" in text and "FBA-28" in text and "snhc run" in text
    assert browser.switch_to.active_element == article
    marked = article.find_elements(By.CSS_SELECTOR, "tr.marked")
    assert "fap_segment" in marked[0].text and "FAP 48" in marked[1].text
    assert len(article.find_elements(By.CSS_SELECTOR, "pre mark")) > 3
    drawing = article.find_element(By.CSS_SELECTOR, "svg")
    assert drawing.size["width"] > 400 and drawing.size["height"] > 100
    page.shot("failure")
    article.find_element(By.CSS_SELECTOR, "nav a").click()
    assert browser.find_element(By.ID, "overview").is_displayed()
    assert shown(page) == ["fap.arith.example.2"]


def test_failures_come_first_and_the_counts_filter(page: Page, mixed: Path) -> None:
    browser = page.open(mixed)
    rows = browser.find_elements(By.CSS_SELECTOR, ".matrix tbody tr")
    failing = [bool(row.find_elements(By.CSS_SELECTOR, "a")) for row in rows]
    assert True in failing and False in failing and failing == sorted(failing, reverse=True)
    assert "wrong value frame 2, FAP 3" in rows[0].find_element(By.CSS_SELECTOR, ".why").text
    everything = shown(page)

    passed = browser.find_elements(By.CSS_SELECTOR, ".count[data-status=pass]")[1]
    assert passed.accessible_name == f"{passed.text} pass, snhc"
    passed.click()
    assert count(page) == f"{passed.text} of {len(everything)} vectors"
    failed = browser.find_element(By.CSS_SELECTOR, ".count[data-adapter='0'][data-status=fail]")
    failed.click()
    assert count(page) == f"{failed.text} of {len(everything)} vectors"
    assert failed.get_attribute("aria-pressed") == "true" and passed.get_attribute("aria-pressed") == "false"
    assert all(id.startswith("fap.") for id in shown(page))
    page.shot("counted")
    failed.click()
    assert shown(page) == everything

    # On through the failures, row by row.
    browser.find_element(By.CSS_SELECTOR, ".matrix a").click()
    seen = []
    while True:
        article = browser.find_element(By.CSS_SELECTOR, ".failure:target")
        seen.append(article.find_element(By.TAG_NAME, "h2").text.split()[1])
        following = article.find_elements(By.CSS_SELECTOR, "a[rel=next]")
        if not following:
            break
        following[0].click()
    assert list(dict.fromkeys(seen)) == [id for id, fails in zip(everything, failing, strict=True) if fails]


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [1400, 420])
def test_nothing_is_wider_than_the_window(page: Page, file: Path, theme: str, width: int) -> None:
    browser = page.browser
    features = [{"name": "prefers-color-scheme", "value": theme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    sizes = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", sizes)
    try:
        page.open(file)
        wide = "return document.documentElement.scrollWidth - document.documentElement.clientWidth"
        page.shot(f"{theme}-{width}")
        assert browser.execute_script(wide) <= 0
        browser.find_element(By.CSS_SELECTOR, ".matrix a").click()
        page.shot(f"{theme}-{width}-failure")
        assert browser.execute_script(wide) <= 0
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_words_of_decoders_run_nowhere(page: Page, file: Path) -> None:
    browser = page.open(file)
    for number in range(len(browser.find_elements(By.CSS_SELECTOR, ".failure"))):
        browser.get(f"{file.as_uri()}#failure-{number}")
    assert browser.title.startswith(f"Conformance: {NAME}")
    assert browser.find_elements(By.CSS_SELECTOR, "img, b > b, pre b") == []
    assert any("onerror" in pre.get_attribute("textContent") for pre in browser.find_elements(By.CSS_SELECTOR, ".said"))


def test_a_mesh_that_differs_is_drawn(page: Page, file: Path) -> None:
    browser = page.open(file)
    links = browser.find_elements(By.CSS_SELECTOR, ".matrix a[aria-label^='fail: mesh.delaunay.c']")
    links[0].click()
    article = browser.find_element(By.CSS_SELECTOR, ".failure:target")
    assert "Mesh" in [heading.text for heading in article.find_elements(By.TAG_NAME, "h3")]
    assert len(article.find_elements(By.CSS_SELECTOR, "svg .edge")) > 5
    assert len(article.find_elements(By.CSS_SELECTOR, "svg .candidate.dot")) == 1
    page.shot("mesh")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_can_be_read_in_light_and_dark(page: Page, file: Path, theme: str) -> None:
    features = [{"name": "prefers-color-scheme", "value": theme}]
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    browser = page.open(file)
    pairs = browser.execute_script(
        "const probe = document.createElement('canvas').getContext('2d');"
        "const rgb = (c) => { probe.fillStyle = c; probe.fillRect(0, 0, 1, 1);"
        "  return [...probe.getImageData(0, 0, 1, 1).data].slice(0, 3); };"
        "const back = (e) => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor;"
        "  if (c !== 'rgba(0, 0, 0, 0)') return c; } return 'white'; };"
        "const names = 'h1, p, th, td, .badge, .dim, .title, dt, dd, label, a, mark, summary';"
        "const nodes = [...document.querySelectorAll(names)];"
        "return nodes.map((e) => [e.className || e.tagName, rgb(getComputedStyle(e).color), rgb(back(e))]);"
    )
    page.shot(theme)
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert len(pairs) > 100
    worst = min(pairs, key=lambda pair: contrast(pair[1], pair[2]))
    assert contrast(worst[1], worst[2]) >= 4.5, worst
    dark_background = luminance(pairs[0][2]) < 0.2
    assert dark_background == (theme == "dark")


def luminance(rgb: list[int]) -> float:
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (v / 255 for v in rgb))
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def contrast(a: list[int], b: list[int]) -> float:
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def test_all_of_it_works_by_keyboard_and_has_names(page: Page, file: Path) -> None:
    browser = page.open(file)
    names = []
    counts = len(browser.find_elements(By.CSS_SELECTOR, ".count"))
    for _ in range(counts + 13):
        browser.switch_to.active_element.send_keys(Keys.TAB)
        names.append(browser.switch_to.active_element.accessible_name)
    assert names[0] == "Decoders" and all(name.split()[0].isdigit() for name in names[1 : counts + 1])
    assert names[counts + 1 : counts + 8] == ["Text", "Decoder", "Status", "Tier", "Tool", "Rule", "Clear"]
    assert all(names)
    link = browser.find_element(By.CSS_SELECTOR, ".matrix a")
    assert link.accessible_name.startswith("fail: ")
    link.send_keys(Keys.ENTER)
    assert browser.find_element(By.CSS_SELECTOR, ".failure:target").is_displayed()
    drawings = browser.find_elements(By.CSS_SELECTOR, ".failure:target svg")
    assert drawings
    for drawing in drawings:
        assert drawing.aria_role in ("img", "image") and drawing.find_element(By.TAG_NAME, "title")


def test_without_scripts_failures_open_too(page: Page, file: Path) -> None:
    page.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser = page.open(file)
        assert not browser.find_element(By.ID, "filters").is_displayed()
        browser.find_element(By.CSS_SELECTOR, ".matrix a").click()
        assert browser.find_element(By.CSS_SELECTOR, ".failure:target").is_displayed()
    finally:
        page.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
