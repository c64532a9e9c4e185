"""A headless Chromium for the pages that the project makes. Debian: packages `chromium` and `chromium-driver`.

Pages are opened from `file://`, as their readers do; whatever a page says on the console as an error fails its test.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

# Without these a browser as root in a container does not start, or asks the network for updates of itself.
_ARGUMENTS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-extensions",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
    "--enable-unsafe-swiftshader", "--window-size=1400,1000", "--force-color-profile=srgb", "--hide-scrollbars",
)  # fmt: skip


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    """One browser for all tests."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no Chromium with its driver (Debian: chromium, chromium-driver)")
    options = Options()
    options.binary_location = program
    for argument in (*_ARGUMENTS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(driver))
    browser.set_page_load_timeout(120)
    yield browser
    browser.quit()


class Page:
    """A page in the browser. `shot`: a picture of it into the test's folder, for people."""

    def __init__(self, browser: webdriver.Chrome, folder: Path) -> None:
        self.browser = browser
        self._folder = folder

    def open(self, path: Path) -> webdriver.Chrome:
        """Open a file; what was said on the console before is forgotten."""
        self.browser.get_log("browser")
        self.browser.get(path.absolute().as_uri())
        return self.browser

    def errors(self) -> list[str]:
        """What the console said that is an error, since the last call."""
        return [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]

    def shot(self, name: str) -> Path:
        """A picture of the window."""
        path = self._folder / f"{name}.png"
        assert self.browser.save_screenshot(str(path))
        return path


@pytest.fixture
def page(chromium: webdriver.Chrome, tmp_path: Path) -> Iterator[Page]:
    """A page; errors on its console that the test did not ask for fail it."""
    one = Page(chromium, tmp_path)
    yield one
    assert one.errors() == []
