"""Pages in a real browser: they move, open every design, and everybody can use them."""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import robomore.report
from exhaustive import more_of
from fake_run import finished_run
from report.large_run import large_run
from robomore.report import write_comparison, write_report

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

CHROMIUM = Path(os.environ.get("CHROMIUM", "/usr/bin/chromium"))
MEGABYTE = 10**6

pytestmark = pytest.mark.skipif(
    not CHROMIUM.exists(), reason=f"there is no {CHROMIUM} (Debian's package `chromium`)"
)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """One Chromium for all tests, with WebGL in software."""
    options = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"]
    with sync_api.sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield found
        found.close()


@pytest.fixture
def said() -> Iterator[list[str]]:
    """What the console of a page said; nothing may be left there."""
    lines: list[str] = []
    yield lines
    assert not lines


def opened(browser: Any, file: Path | str, said: list[str], cpu: bool = False) -> Any:
    """Return a page that has come to life; with `cpu`, `page.watched` knows what that cost it."""
    # Nothing plays before it is asked to: drawing in software is slow.
    size = {"width": 1280, "height": 800}
    page = browser.new_page(viewport=size, reduced_motion="reduce")
    if cpu:
        page.watched = page.context.new_cdp_session(page)
        # Time of the page's own thread: what others do on this machine does not count.
        page.watched.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.set_default_timeout(60_000)
    page.on("console", lambda line: said.append(f"{line.type}: {line.text}"))
    page.on("pageerror", lambda error: said.append(f"error: {error}"))
    page.on("dialog", lambda dialog: said.append(f"a dialog: {dialog.message}"))
    page.goto(file if isinstance(file, str) else file.as_uri())
    page.wait_for_selector("html[data-ready]")
    return page


def until(page: Any, expression: str) -> None:
    """Wait for something to be true in a page, whose policy forbids Playwright's own way."""
    end = time.monotonic() + 60
    while not page.evaluate(expression):
        assert time.monotonic() < end, f"it never came to {expression}"
        page.wait_for_timeout(50)


def faults(page: Any) -> list[str]:
    """Return the serious faults that axe finds in a page."""
    import axe_playwright_python

    axe = Path(axe_playwright_python.__file__).with_name("axe.min.js").read_text()
    page.evaluate(axe)
    found = page.evaluate("() => axe.run(document, {resultTypes: ['violations']})")
    return [
        f"{one['id']}: {one['nodes'][0]['html'][:200]}"
        for one in found["violations"]
        if one["impact"] in ("serious", "critical")
    ]


PIXELS = """(canvas) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [160, 90];
  const pen = copy.getContext("2d");
  pen.drawImage(canvas, 0, 0, 160, 90);
  return Array.from(pen.getImageData(0, 0, 160, 90).data).join();
}"""


def test_robots_move_and_everybody_can_use_the_page(
    browser: Any, trained_run: Path, tmp_path: Path, said: list[str]
) -> None:
    page = opened(browser, write_report(trained_run, tmp_path / "report.html"), said)
    player = page.locator("#motion .player")
    player.scroll_into_view_if_needed()
    canvas = player.locator("canvas")
    until(page, "document.querySelector('#motion .player').dataset.ready !== undefined")
    first = canvas.evaluate(PIXELS)
    assert len(set(first.split(","))) > 20, "the canvas is blank"
    player.get_by_role("button", name="Play").click()
    until(page, "Number(document.querySelector('#motion [name=time]').value) > 0.5")
    player.get_by_role("button", name="Pause").click()
    assert canvas.evaluate(PIXELS) != first
    for name in ("contacts", "torques", "trail", "race"):
        player.get_by_label(name).check()
    canvas.press("ArrowLeft")
    assert canvas.evaluate(PIXELS) != first
    page.emulate_media(color_scheme="dark")
    assert faults(page) == []
    page.emulate_media(color_scheme="light")
    page.set_viewport_size({"width": 390, "height": 800})
    assert faults(page) == []
    wide = "document.documentElement.scrollWidth <= document.documentElement.clientWidth"
    assert page.evaluate(wide), "the page scrolls sideways on a phone"
    page.close()


def test_every_cell_opens_its_design_and_text_stays_text(
    browser: Any, tmp_path: Path, said: list[str]
) -> None:
    run = finished_run(tmp_path / "run")
    page = opened(browser, write_report(run.path, tmp_path / "report.html"), said)
    dialog = page.locator("dialog#design")
    cells = page.locator("figure:has-text('every morphology') .tip[data-key]")
    keys = cells.evaluate_all("(cells) => cells.map((cell) => cell.dataset.key)")
    assert len(keys) == 12
    for n, key in enumerate(keys):
        cells.nth(n).dispatch_event("click")
        until(page, f"document.querySelector('#design').dataset.shown === '{key}'")
        assert dialog.is_visible()
        assert dialog.locator("pre").first.inner_text().startswith("def _get_rew")
        if n == len(keys) - 1:
            # What a designer wrote is there to be read, and nothing more.
            assert "<script>alert('x')</script>" in dialog.inner_text()
            assert dialog.locator("svg.figure").count() >= 3, "curves"
            assert faults(page) == []
        page.keyboard.press("Escape")
    assert page.locator("script:not([type])").count() == 1
    # The keyboard reaches every mark of a figure, and opens it.
    cells.first.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    until(page, f"document.querySelector('#design').dataset.shown === '{keys[3]}'")
    page.keyboard.press("Escape")
    rows = page.locator(".evaluations tbody tr")
    page.locator(".evaluations input").fill("fine: branch 1, cycle 1, new morphology")
    assert rows.count() == 1
    rows.first.get_by_role("button").click()
    assert "Against its parent" in dialog.inner_text()
    page.close()


@pytest.mark.parametrize("rows", more_of([10, 50], 10))
def test_a_run_of_400_or_2000_evaluations(
    rows: int, browser: Any, tmp_path: Path, said: list[str]
) -> None:
    large_run(tmp_path / "run", rows)
    began = time.process_time()
    file = write_report(tmp_path / "run", tmp_path / "report.html")
    assert time.process_time() - began < 20
    assert file.stat().st_size < 15 * MEGABYTE
    page = opened(browser, file, said, cpu=True)
    measured = page.watched.send("Performance.getMetrics")["metrics"]
    assert next(one["value"] for one in measured if one["name"] == "TaskDuration") < 2
    click = "dispatchEvent(new MouseEvent('click', {bubbles: true}))"
    last = f"pair{40 * rows - 1:05d}"
    page.evaluate(f"document.querySelector('[data-key={last}]').{click}")
    until(page, f"document.querySelector('#design').dataset.shown === '{last}'")
    page.close()


def test_a_comparison(browser: Any, trained_run: Path, tmp_path: Path, said: list[str]) -> None:
    finished_run(tmp_path / "other")
    file = write_comparison([trained_run, tmp_path / "other"], tmp_path / "comparison.html")
    page = opened(browser, file, said)
    table = page.locator("table.sortable").last
    numbers = [cell.inner_text() for cell in table.locator("tbody td:nth-child(8)").all()]
    table.get_by_role("button", name="fitness").click()
    table.get_by_role("button", name="fitness").click()
    assert [cell.inner_text() for cell in table.locator("tbody td:nth-child(8)").all()] == sorted(
        numbers, key=float
    )
    assert faults(page) == []
    page.close()


def test_the_live_page_follows_a_run(browser: Any, tmp_path: Path, said: list[str]) -> None:
    uvicorn = pytest.importorskip("uvicorn", reason="the extra [serve] is not installed")
    pytest.importorskip("sse_starlette", reason="the extra [serve] is not installed")
    from fake_run import FakeRun
    from robomore.serve import application

    run = FakeRun(tmp_path / "first")
    run.coarse()
    server = uvicorn.Server(
        uvicorn.Config(application(tmp_path), port=0, log_level="error", lifespan="off",
                       timeout_graceful_shutdown=0)
    )  # fmt: skip
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    (socket,) = server.servers[0].sockets
    address = f"http://127.0.0.1:{socket.getsockname()[1]}/"
    runs = opened(browser, address, said)
    live = "document.querySelector('[data-connection]').textContent === 'live'"
    page = opened(browser, f"{address}run?name=first", said)
    for one in (runs, page):
        until(one, live)
    runs.click("text=time left")
    runs.click("text=time left")
    before = runs.inner_text("tbody")
    best = run.fine()
    until(runs, f"document.querySelector('tbody').innerText !== {json.dumps(before)}")
    assert runs.get_attribute("th:last-child", "aria-sort") == "ascending"
    runs.close()
    page.wait_for_selector(f"[data-key={best.key}]", state="attached", timeout=20_000)
    assert faults(page) == []
    mark = page.locator(f"[data-key={best.key}]").first
    mark.evaluate("(mark) => mark.dispatchEvent(new MouseEvent('click', {bubbles: true}))")
    page.wait_for_url(f"**/run/report?name=first#{best.key}")
    until(page, f"document.querySelector('#design')?.dataset.shown === '{best.key}'")
    page.close()
    server.should_exit = True
    thread.join(10)


def test_a_zero_has_no_sign(browser: Any) -> None:
    page = browser.new_page()
    words = (Path(robomore.report.__file__).parent / "web" / "words.js").read_text()
    called = """async (text) => {
      const words = await import("data:text/javascript," + encodeURIComponent(text));
      return [-0.03, -0.06, 12.34].map(words.tenths);
    }"""
    assert page.evaluate(called, words) == ["0.0", "-0.1", "12.3"]
    page.close()
