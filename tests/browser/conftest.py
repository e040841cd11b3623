"""A headless Chromium, driven as a person does; skipped with the reason where there is none."""

import json
import shutil
from pathlib import Path

import pytest
from product import PATIENCE

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--window-size=1200,900",
)


def pytest_collection_modifyitems(items):
    for item in items:
        if "browser" in Path(item.fspath).parts:
            item.add_marker(pytest.mark.browser)


def _program(*names):
    found = next((path for name in names if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"{names[0]} is not installed (Debian: apt-get install chromium-driver)")
    return found


@pytest.fixture(scope="session")
def browser():
    """Start a browser that keeps what pages log and what they ask the network for."""
    selenium = pytest.importorskip("selenium", reason="the extra `browser` is not installed")
    del selenium
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = _program("chromium", "chromium-browser", "google-chrome")
    driver = _program("chromedriver", "chromium.chromedriver")
    for flag in FLAGS:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    # With the driver named, selenium looks for none on the network.
    with webdriver.Chrome(options=options, service=Service(driver)) as started:
        started.set_page_load_timeout(PATIENCE)
        yield started


def requests_of(browser) -> list[str]:
    """Return the addresses that were asked for since the last call."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    return [
        message["params"]["request"]["url"]
        for message in messages
        if message["method"] == "Network.requestWillBeSent"
    ]


@pytest.fixture
def asked():
    """Return the function that lists what pages asked for."""
    return requests_of
