"""The report as a person sees it: it opens from the disk, has its plots, and zooms."""

import numpy as np
import pytest
import rail_cosim
from product import PATIENCE
from rail_cosim.reporting import page
from synthetic import whole_run

CHARTS = 23
_AXIS = "return document.querySelectorAll('.chart')[{}].layout.{}.range"


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    """Return the browser with the page of a whole run, all charts drawn."""
    from selenium.webdriver.support.ui import WebDriverWait

    path = tmp_path_factory.mktemp("report") / "run.html"
    rail_cosim.report(whole_run(), path)
    browser.get(path.as_uri())
    for number in range(CHARTS):
        browser.execute_script(f"document.querySelectorAll('.chart')[{number}].scrollIntoView()")
        WebDriverWait(browser, PATIENCE).until(lambda b, n=number: _drawn(b, n))
    return browser


def _drawn(browser, number):
    return browser.execute_script(
        f"return document.querySelectorAll('.chart')[{number}].querySelector('.plot-container "
        "svg.main-svg') !== null"
    )


def test_it_opens_without_error_and_without_network(opened, asked):
    assert opened.title == "Run: line HD, 288 km/h"
    assert [e for e in opened.get_log("browser") if e["level"] != "INFO"] == []
    addresses = asked(opened)
    assert addresses[0].startswith("file://")
    assert all(one.startswith(("file:///", "data:", "blob:")) for one in addresses)
    assert sum(one.startswith("file:///") for one in addresses) == 1


def test_every_chart_has_lines_with_points(opened):
    script = (
        "return [...document.querySelectorAll('.chart')].map(c => "
        "c.querySelectorAll('.scatterlayer .js-line, .hm image').length)"
    )
    found = opened.execute_script(script)
    assert len(found) == CHARTS
    assert min(found) >= 1
    paths = opened.execute_script(
        "return [...document.querySelector('.chart').querySelectorAll('.scatterlayer .js-line')]"
        ".map(p => p.getAttribute('d').length)"
    )
    assert len(paths) == 4  # the left wheels; the right ones are in the legend only
    assert min(paths) > 1000


def test_the_picture_is_drawn(opened):
    box = opened.execute_script(
        "const r = document.querySelector('figure svg').getBoundingClientRect();"
        "return [r.width, r.height]"
    )
    assert box[0] > 800
    assert box[1] > 100


def test_dragging_zooms_and_double_click_goes_back(opened):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By

    before = np.array(opened.execute_script(_AXIS.format(0, "xaxis")), dtype=float)
    plot = opened.find_elements(By.CSS_SELECTOR, ".chart")[0]
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    area = plot.find_element(By.CSS_SELECTOR, ".nsewdrag")
    width, height = area.size["width"], area.size["height"]
    drag = ActionChains(opened, duration=100).move_to_element(area)
    drag.move_by_offset(-width // 4, -height // 4).click_and_hold()
    drag.move_by_offset(width // 2, height // 2).release().perform()
    after = np.array(opened.execute_script(_AXIS.format(0, "xaxis")), dtype=float)
    assert np.ptp(after) == pytest.approx(0.5 * np.ptp(before), rel=0.05)
    assert np.ptp(opened.execute_script(_AXIS.format(0, "yaxis"))) > 0.0
    ActionChains(opened).move_to_element(area).double_click().perform()
    again = np.array(opened.execute_script(_AXIS.format(0, "xaxis")), dtype=float)
    assert again == pytest.approx(before)


def test_a_click_in_the_legend_shows_the_right_wheels(opened):
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait

    plot = opened.find_elements(By.CSS_SELECTOR, ".chart")[0]
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    plot.find_elements(By.CSS_SELECTOR, ".legendtoggle")[1].click()
    lines = "document.querySelector('.chart').querySelectorAll('.scatterlayer .js-line')"
    WebDriverWait(opened, PATIENCE).until(lambda b: b.execute_script(f"return {lines}.length") == 5)


def test_nothing_hides_something_else(opened):
    """No wider than the window, and no legend over the title of an axis."""
    assert opened.execute_script(
        "return document.documentElement.scrollWidth <= document.documentElement.clientWidth"
    )
    overlaps = opened.execute_script(
        """return [...document.querySelectorAll('.chart')].filter(c => {
          const a = c.querySelector('.legend'), b = c.querySelector('.xtitle');
          if (!a || !b) { return false; }
          const p = a.getBoundingClientRect(), q = b.getBoundingClientRect();
          return p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom;
        }).length"""
    )
    assert overlaps == 0


def test_hostile_names_run_no_script(browser, tmp_path):
    hostile = "</script><img src=x onerror=\"document.title='bad'\">"
    path = tmp_path / "hostile.html"
    run = whole_run(20.0, command=hostile, line=hostile, **{f"track.{hostile}": hostile})
    path.write_text(page(run, hostile), encoding="utf-8")
    browser.get(path.as_uri())
    assert browser.title.startswith("Run: line </script>")
    assert browser.execute_script("return document.querySelectorAll('img').length") == 0
