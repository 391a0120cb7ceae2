"""The live pages: what they say of runs that begin, go on, end, vanish and are damaged."""

from __future__ import annotations

import asyncio
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("starlette", reason="the extra [serve] is not installed")
pytest.importorskip("sse_starlette", reason="the extra [serve] is not installed")

from starlette.applications import Starlette

from fake_run import NASTY, FakeRun, finished_run
from robomore.events import RunBegan
from robomore.monitor.progress import Progress, ProgressFile, Under, read_progress
from robomore.plan import Plan, Stage
from robomore.rendering.packing import unpack
from robomore.runs import load_run
from robomore.runs.words import number
from robomore.serve import application
from robomore.serve.app import changes
from robomore.serve.folder import Look, ServedFolder
from robomore.text import to_json
from robomore.types import Place
from serve.asking import ask


def page(app: Starlette, address: str) -> str:
    answer = ask(app, address)
    assert answer.status == 200, answer.body
    return answer.body.decode()


def told(run: FakeRun, **changes: Any) -> None:
    """Write down how far a run is."""
    known: dict[str, Any] = {
        "time": time.time(), "elapsed": 60.0, "left": 120.0, "stage": "coarse", "asked": 12,
        "done": 5, "finished": 5, "failed": 1, "known": 0, "workers": 2,
        "running": (Under("coarse: morphology 2, reward 3", 0.5),), "steps": 5000,
        "budget": None, "trouble": NASTY,
    }  # fmt: skip
    run.folder.progress.write_bytes(to_json(Progress(**known | changes)))


def test_runs_appear_go_on_end_and_vanish(tmp_path: Path) -> None:
    app = application(tmp_path)
    assert "There is no run here yet" in page(app, "/")

    run = FakeRun(tmp_path / "a" / "first")
    told(run)
    shown = page(app, "/")
    assert "a/first" in shown and "running" in shown and "about 2 min" in shown
    one = page(app, "/run?name=a/first")
    assert "5 of 12 in this batch, 1 failed; about 2 min left; 300 evaluations an hour" in one
    assert "coarse: morphology 2, reward 3" in one
    assert NASTY not in one
    assert "Nothing has been trained yet" in one

    best = run.coarse()
    time.sleep(0.3)  # the run is not read twice within a moment
    shown = page(app, "/run?name=a/first")
    assert "so far" in shown and f'data-key="{best.key}"' in shown

    run.final(best)
    told(run, over=True, left=0.0)
    time.sleep(0.3)
    assert "finished" in page(app, "/")
    assert "about" not in page(app, "/run?name=a/first&part=progress")

    shutil.rmtree(tmp_path / "a")
    assert ask(app, "/run?name=a/first").status == 404
    assert "There is no run here yet" in page(app, "/")


def test_a_small_ratio_has_its_digits(tmp_path: Path) -> None:
    fake = FakeRun(tmp_path / "one")
    fake.final(fake.coarse(), found=(0.001,) * 5)
    run = load_run(tmp_path / "one")
    assert run.ratio is not None and run.ratio.mean < 0.005
    assert f"{number(run.ratio.mean, 3)}\N{MULTIPLICATION SIGN}" in page(application(tmp_path), "/")


def test_a_change_within_the_rest_is_told_when_the_rest_is_over(tmp_path: Path) -> None:
    run = FakeRun(tmp_path / "one")
    run.coarse()
    folder = ServedFolder(tmp_path)
    one = folder.run("one")
    assert one is not None

    async def follow(look: Callable[[], Look]) -> None:
        stream = changes(look, seconds=0.01)
        assert await anext(stream) == "changed"
        found = one.read().run
        one._rested = time.monotonic() + 60.0
        # The run ends while the page rests: whoever asked would be given what was read before.
        os.utime(run.folder.ledger)
        assert one.read().run is found
        waiting = asyncio.ensure_future(anext(stream))
        await asyncio.sleep(0.1)
        assert not waiting.done()
        one._rested = 0.0
        assert await asyncio.wait_for(waiting, 5.0) == "changed"
        assert one.read().run is not found

    for look in (one.look, folder.look):
        one._rested = 0.0
        os.utime(run.folder.ledger)
        asyncio.run(asyncio.wait_for(follow(look), 30.0))


def test_whoever_did_not_ask_hears_of_what_another_page_had_read() -> None:
    looks = iter(
        [
            Look(1, 1, due=False, progress=0),
            Look(1, 1, due=False, progress=1),
            Look(2, 1, due=False, progress=1),  # within the rest
            Look(2, 2, due=False, progress=1),  # another page asked
            Look(3, 2, due=True, progress=1),
            Look(3, 3, due=False, progress=1),
            Look(3, 3, due=False, progress=2),
        ]
    )

    async def heard() -> list[str]:
        told = []
        stream = changes(lambda: next(looks), seconds=0.0)
        async for name in stream:
            told.append(name)
            if len(told) == 5:
                break
        return told

    assert asyncio.run(asyncio.wait_for(heard(), 30.0)) == [
        "changed",
        "progress",
        "changed",
        "changed",
        "progress",
    ]


def test_a_run_that_was_killed_is_not_called_running(tmp_path: Path) -> None:
    run = FakeRun(tmp_path / "killed")
    run.coarse()
    told(run, time=time.time() - 3600)
    shown = page(application(tmp_path), "/run?name=killed")
    assert "stopped" in shown.lower()
    assert "left" not in shown


def test_a_time_to_come_is_no_sign_of_life(tmp_path: Path) -> None:
    run = FakeRun(tmp_path / "ahead")
    run.coarse()
    told(run, time=time.time() + 3600)
    shown = page(application(tmp_path), "/run?name=ahead")
    assert "Stopped" in shown and "left" not in shown


@pytest.mark.parametrize(
    "changes",
    [
        {"running": (Under("here", 1e308),)},
        {"running": (Under("here", -0.5),)},
        {"left": 1e300},
        {"elapsed": -1.0},
        {"done": -1},
        {"steps": 10**15},
    ],
)
def test_absurd_progress_hides_no_run(tmp_path: Path, changes: dict[str, Any]) -> None:
    run = FakeRun(tmp_path / "one")
    best = run.coarse()
    told(run, **changes)
    assert read_progress(run.folder.progress) is None
    shown = page(application(tmp_path), "/run?name=one")
    assert "cannot be shown" not in shown and f'data-key="{best.key}"' in shown


def test_an_error_is_said_once_and_as_it_is(tmp_path: Path) -> None:
    run = FakeRun(tmp_path / "NoLedger")
    run.folder.ledger.unlink(missing_ok=True)
    shown = page(application(tmp_path), "/run?name=NoLedger").split("<header>", 1)[1]
    assert shown.count("has no ledger") == 1 and "NoLedger has no ledger" in shown
    assert "noledger" not in shown


@pytest.mark.parametrize(("shape", "drawn"), [((20, 20), True), ((200, 20), False)])
def test_a_grid_too_large_to_send_again_and_again_is_left_out(
    tmp_path: Path, shape: tuple[int, int], drawn: bool
) -> None:
    stage = Stage(name="matrix", axes=("morphology", "reward"), shape=shape, evaluations=4)
    run = FakeRun(tmp_path / "one", plan=Plan((stage,)), preset="custom")
    run.add(run.reference, Place(stage="matrix", index=(0, 0)), 10.0)
    shown = page(application(tmp_path), "/run?name=one")
    assert "The best now" in shown and ("Stage matrix" in shown) is drawn


def test_a_damaged_run_says_so_and_the_others_are_shown(tmp_path: Path) -> None:
    finished_run(tmp_path / "good")
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "run.json").write_text("{")
    shown = page(application(tmp_path), "/")
    assert "is damaged" in shown
    assert "good" in shown and "finished" in shown


@pytest.mark.parametrize(
    "name", ["../secret", "..", "/etc", "good/../../secret", "%2e%2e/secret", "link", "good/"]
)
def test_only_names_that_are_listed_are_served(tmp_path: Path, name: str) -> None:
    root = tmp_path / "root"
    FakeRun(root / "good")
    FakeRun(tmp_path / "secret")
    (root / "link").symlink_to(tmp_path / "secret")
    app = application(root)
    for where in ("/run", "/run/report", "/run/replay"):
        assert ask(app, f"{where}?name={name}").status == 404
    assert ask(app, "/../secret").status == 404
    assert ask(app, "/static/../../secret").status == 404
    assert "secret" not in page(app, "/")


def test_what_moves_and_the_whole_report(trained_run: Path) -> None:
    app = application(trained_run)
    shown = page(app, "/run?name=.")
    assert "/run/replay?name=." in shown
    report = page(app, "/run/report?name=.")
    assert 'data-pack="page"' in report
    key = report.split('data-pack="', 1)[1].split('"', 1)[0]
    answer = ask(app, f"/run/replay?name=.&key={key}")
    assert answer.status == 200
    assert unpack(answer.body)["frames"] > 10
    assert ask(app, "/run/replay?name=.&key=../../etc").status == 404


def test_a_run_tells_how_far_it_is_at_most_once_a_second(tmp_path: Path, began: RunBegan) -> None:
    clock = [0.0]
    seen: list[object] = []
    file = tmp_path / "progress.json"
    observer = ProgressFile(file, seen.append, lambda: clock[0])
    assert read_progress(file) is None
    observer(began)
    first = read_progress(file)
    assert first is not None and not first.over
    for clock[0] in (0.1, 0.2):
        observer(began)
    assert read_progress(file) == first
    assert len(seen) == 3
    clock[0] = 5.0
    observer.close()
    last = read_progress(file)
    assert last is not None and last.over and last.elapsed == 5.0


@pytest.mark.parametrize("content", [b"{", b"[]", b'{"time": "x"}', b"[" * 100_000])
def test_nonsense_about_progress_is_no_progress(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "progress.json"
    file.write_bytes(content)
    assert read_progress(file) is None
    file.unlink()
    file.symlink_to("/etc/passwd")
    assert read_progress(file) is None
