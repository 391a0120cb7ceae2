"""A run that cannot be shown has a page that says so, and hides no other run."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("starlette", reason="the extra [serve] is not installed")
pytest.importorskip("sse_starlette", reason="the extra [serve] is not installed")

from fake_run import FakeRun
from robomore.runs import Run
from robomore.serve import app as pages
from robomore.serve import application, folder, live
from serve.asking import ask


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name in ("bad", "good"):
        FakeRun(tmp_path / name).coarse()
    return tmp_path


def fault_in(name: str) -> ZeroDivisionError:
    return ZeroDivisionError(f"nobody\nthought of {name}")


def test_a_run_that_cannot_be_read_has_a_page(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = folder.load_run

    def load_run(path: Path) -> Run:
        if path.name == "bad":
            raise fault_in("reading")
        return real(path)

    monkeypatch.setattr(folder, "load_run", load_run)
    app = application(root)
    said = "it cannot be shown (ZeroDivisionError: nobody thought of reading)"
    for address in ("/", "/run?name=bad", "/run?name=bad&part=progress"):
        answer = ask(app, address)
        assert answer.status == 200 and said in answer.body.decode()
    report = ask(app, "/run/report?name=bad")
    assert report.status == 404 and "robomore report" in report.body.decode()
    assert "so far" in ask(app, "/run?name=good").body.decode()


def test_a_run_that_cannot_be_drawn_has_a_page(
    root: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def failing(run: Run) -> str:
        raise fault_in("drawing")

    monkeypatch.setattr(live, "best_so_far", failing)
    monkeypatch.setattr(pages, "render", failing)
    app = application(root)
    answer = ask(app, "/run?name=bad")
    assert answer.status == 200 and "nobody thought of drawing" in answer.body.decode()
    report = ask(app, "/run/report?name=bad")
    assert report.status == 500 and "nobody thought of drawing" in report.body.decode()
    assert "Traceback" in caplog.text, "whoever serves sees where"


def test_a_run_without_a_line_hides_no_other(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = live.in_unit

    def failing(number: float | None, objective: str, unit: str) -> str:
        raise fault_in("a unit")

    monkeypatch.setattr(live, "in_unit", failing)
    app = application(root)
    shown = ask(app, "/").body.decode()
    assert shown.count("nobody thought of a unit") == 2 and "good" in shown
    monkeypatch.setattr(live, "in_unit", real)
    assert "nobody" not in ask(app, "/").body.decode()
