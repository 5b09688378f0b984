"""The HTML report: one file, opened by a browser without an error, with its pictures drawn."""
from __future__ import annotations

import json
import pathlib
import re
import shutil
import subprocess

import pytest

numpy = pytest.importorskip("numpy")
pytest.importorskip("amb_rotor._core")

from amb_rotor.report import data, numbers, page  # noqa: E402

needs_browser = pytest.mark.skipif(not (shutil.which("chromium") and shutil.which("chromedriver")),
                                   reason="chromium or its driver is not installed")


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A headless Chromium for all pages; its start takes longer than a page."""
    webdriver = pytest.importorskip("selenium.webdriver")
    options = webdriver.ChromeOptions()
    for flag in ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
                 "--disable-component-update", "--disable-sync", f"--user-data-dir={tmp_path_factory.mktemp('profile')}",
                 "--window-size=1240,1600"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(service=webdriver.chrome.service.Service("/usr/bin/chromedriver"), options=options)
    driver.set_page_load_timeout(60)
    yield driver
    driver.quit()


def in_browser(driver, path: pathlib.Path, look):
    """Opens a page; look(driver) while it is there. Returns the console's errors since then too."""
    driver.get_log("browser")  # what an earlier page left is taken away
    driver.get(path.as_uri())
    return look(driver), [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]


LOOK = """return {ready: document.body.dataset.ready, title: document.querySelector('h1').textContent,
  verdict: document.querySelector('.verdict').textContent, plots: document.querySelectorAll('.js-plotly-plot').length,
  drawn: document.querySelectorAll('.js-plotly-plot .main-svg').length, text: document.body.innerText,
  wide: document.documentElement.scrollWidth, empty: [...document.querySelectorAll('.js-plotly-plot')]
    .filter(p => !p.querySelector('.trace, .bars, .hm, image')).length,
  axes: [...document.querySelectorAll('.js-plotly-plot')].filter(p => !(p.layout.xaxis.title || {}).text).length};"""


@needs_browser
def test_the_browser_draws_a_diagnosis_without_an_error(chain, browser):
    def look(driver):
        seen = driver.execute_script(LOOK)
        for select in driver.find_elements("css selector", ".picks select"):
            for option in select.find_elements("tag name", "option"):
                option.click()
        seen["errors_of_plotly"] = driver.execute_script("return document.querySelectorAll('.plotly-notifier').length")
        return seen

    seen, errors = in_browser(browser, chain.folder / "out" / "diagnosis" / "report.html", look)
    assert not errors
    assert seen["ready"] == "yes" and "cross coupled stiffness" in seen["verdict"]
    assert seen["plots"] >= 10 and seen["drawn"] >= seen["plots"] and seen["empty"] == 0 and seen["axes"] == 0
    assert "2.34 → 1.01" in seen["text"] or re.search(r"\d\.\d\d → \d\.\d\d", seen["text"])
    assert "stiffness_N_per_m" in seen["text"] and "±" in seen["text"] and "NaN" not in seen["text"]
    assert seen["wide"] <= 1240


@needs_browser
def test_a_fault_in_the_page_would_be_seen(tmp_path, browser):
    path = tmp_path / "broken.html"
    path.write_text("<body class=x><h1></h1><p class=verdict></p><script>nonsense();</script></body>")
    _, errors = in_browser(browser, path, lambda driver: None)
    assert errors


def test_the_report_needs_no_network(chain):
    text = (chain.folder / "out" / "believed" / "report.html").read_text()
    elements = re.findall(r"""<(?:script|link|img|iframe)[^>]+(?:src|href)\s*=\s*["']([^"']*)""", text)
    assert elements and all(target.startswith("data:") for target in elements)


def hand_made() -> dict:
    """A diagnosis with everything in it that can be there."""
    parameter = {"force_x_N": {"value": 1.0, "std": 0.1, "unit": "N"}}
    row = {"effect": "static_load", "parameters": parameter, "fit_error": 1.1, "validation_error": 1.2,
           "validation_error_free": 1.1, "validation_error_contact": 1.4, "evidence": 40.0,
           "confounded_with": ["shaft_bow"], "experiment": "slow roll", "excited": True, "plausible": True, "note": ""}
    return {"format": "amb-diagnosis/1", "verdict": "unknown", "noise_floor": 1.0,
            "baseline": {"fit_error": 3.0, "validation_error": 3.1, "validation_error_free": 2.0,
                         "validation_error_contact": 4.0, "nuisance": {}},
            "ranking": [row, {**row, "effect": "shaft_crack", "excited": False, "evidence": -1e6}],
            "steps": [{**row, "added": "static_load"}],
            "unexplained": {"depends_on": ["position", "spin speed"], "shape": "cubic",
                            "terms": [{"term": "x * |x|^2", "coefficient": 3.0, "std": 0.2}], "held_out_gain": 0.4},
            "sentences": ["</script><b>not a tag</b>"], "remarks": ["a remark"], "seconds": 1.0}


@needs_browser
def test_unknown_twins_and_contact_are_shown_and_text_is_text(tmp_path, browser):
    diagnosis = hand_made()
    revisions = [{"label": "believed", **diagnosis["baseline"]}, {"label": "+ static_load", **diagnosis["steps"][0]}]
    both = [{"name": "the others at 0", "x": [0.0, 0.0], "y": [0.0, 0.0]},
            {"name": "the others at the end of their range", "x": [-1.0, 1.0], "y": [0.0, 0.0]}]
    law = [{"quantity": "position", "axis": "displacement along x [µm]", "at": [-40.0, 40.0], "curves": both},
           {"quantity": "spin speed", "axis": "spin speed [Hz]", "at": [0.0, 50.0], "curves": both}]
    path = page.write_report(tmp_path / "r.html", "A <title>", "sub", [], diagnosis, revisions, law=law)
    seen, errors = in_browser(browser, path, lambda driver: driver.execute_script(LOOK))
    assert not errors and seen["title"] == "A <title>"
    for text in ("no name for", "</script><b>not a tag</b>", "slow roll", "not excited by these runs", "shaft bow",
                 "position, spin speed", "x * |x|^2", "takes 40 %", "The law over the spin speed"):
        assert text in seen["text"]
    assert seen["plots"] == 4 and seen["drawn"] >= 4 and seen["empty"] == 0 and seen["axes"] == 0, "ranking, falling error, two of the law"


@needs_browser
@pytest.mark.parametrize("place, beside, axis", [
    ("sensors", "What a sensor adds to its signal", "added to the signal [µm]"), ("tilt", "its opposite at a", "force [N]"),
    ("magnetic_bearings", "Force at bearing a", "force [N]")])
def test_a_law_is_drawn_as_what_it_is(place, beside, axis, tmp_path, browser):
    diagnosis = hand_made()
    width = 8.7e-6 if place == "sensors" else None
    diagnosis["unexplained"] |= {"place": place, "plane_z_m": None, "step_width_m": width}
    law = [{"quantity": "position", "axis": "displacement along x [µm]", "at": [-40.0, 40.0],
            "curves": [{"name": "", "x": [2.0, -2.0], "y": [0.0, 0.0]}]}]
    path = page.write_report(tmp_path / "r.html", "A <title>", "sub", [], diagnosis, [], law=law)
    seen, errors = in_browser(browser, path, lambda driver: driver.execute_script(LOOK) | {"axes_of_y": driver.execute_script(
        "return [...document.querySelectorAll('.js-plotly-plot')].map(p => ((p.layout.yaxis || {}).title || {}).text)")})
    assert not errors and beside in seen["text"] and axis in seen["axes_of_y"]
    assert ("width w of the step" in seen["text"]) == (width is not None)


def test_an_envelope_keeps_the_extremes():
    values = numpy.random.default_rng(1).normal(size=9999)
    seen = data.envelope(values, 100)
    assert len(seen) == 200 == len(data.envelope_times(9999, 1e4, 100))
    assert seen.max() == values.max() and seen.min() == values.min()
    assert (data.envelope(values[:50], 100) == values[:50]).all()


def test_numbers_that_are_not_finite_become_null():
    assert json.loads(page.embedded({"a": float("nan"), "b": numbers.short([1.23456, float("inf")])})) == \
        {"a": None, "b": [1.235, None]}


def test_html_is_written_whole(tmp_path):
    page.write_report(tmp_path / "r.html", "t", "s", [])
    assert [path.name for path in tmp_path.iterdir()] == ["r.html"]
    assert subprocess.run(["grep", "-c", "@DATA@\\|@SCRIPT@\\|@STYLE@", tmp_path / "r.html"],
                          capture_output=True, text=True, check=False).stdout.strip() == "0"
