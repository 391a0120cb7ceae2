"""A disk that is full, a medium that cannot be written: one line, and nothing finished is lost."""

from __future__ import annotations

import json
import resource
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest
from lives import killed_run
from quick_run import SMOKE, command, ended, environment
from refusals import Command, Said, facts, refused
from run_state import rows, same_run

from robomore.evaluation import evaluator
from robomore.store import Ledger, RunFolder
from strict import strictly


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of its own, as small as `resize` makes it."""
    folder = tmp_path / "disk"
    folder.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(folder)],
        capture_output=True,
        check=False,
    )
    if made.returncode:
        pytest.skip("this user cannot mount a file system; the limit on file sizes stands in")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def resize(folder: Path, options: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{options}", str(folder)], check=True)


@pytest.mark.parametrize(
    ("work", "kib"),
    [
        ("made_up", 240),
        pytest.param("made_up", 24, marks=pytest.mark.exhaustive),
        *(pytest.param("quick", kib, marks=pytest.mark.exhaustive) for kib in (20, 260, 380, 480)),
    ],
)
def test_a_full_disk_stops_a_run_that_goes_on_once_there_is_space(
    work: str, kib: int, small_disk: Path, undisturbed: Path, request: pytest.FixtureRequest
) -> None:
    like = undisturbed if work == "made_up" else request.getfixturevalue("trained") / "run"
    resize(small_disk, f"size={kib}k")
    out = small_disk / "run"
    done = ended(*SMOKE, "--workers", "2", "--out", out, work=work)
    stopped(done)
    finished = rows(out)
    resize(small_disk, "size=64m")
    again = ended(*SMOKE, "--workers", "2", "--out", out, work=work)
    assert again.returncode == 0, again.stderr
    assert finished.items() <= rows(out).items()
    same_run(out, like)
    resize(small_disk, "ro")
    shown = ended("show", out, "--json")
    assert shown.returncode == 0, shown.stderr
    resize(small_disk, "rw")


def test_a_disk_without_room_for_the_report_has_the_whole_run(small_disk: Path) -> None:
    resize(small_disk, "size=480k")
    out = small_disk / "run"
    done = ended(*SMOKE, "--workers", "1", "--out", out)
    assert done.returncode == 1, done.stderr
    stopped(done)
    assert "its report cannot be written (No space left on device)" in done.stderr
    shown = ended("show", out, "--json")
    assert shown.returncode == 0 and json.loads(shown.stdout)["final"]
    resize(small_disk, "size=64m")
    assert ended("report", out).returncode == 0 and (out / "report.html").is_file()


@pytest.mark.exhaustive  # A full disk is much the same.
@pytest.mark.parametrize("kib", [8, 48])
def test_files_that_may_not_grow_stop_a_run_in_the_same_way(
    kib: int, tmp_path: Path, trained: Path
) -> None:
    out = tmp_path / "run"
    bytes_ = kib * 1024
    done = subprocess.run(
        command(*SMOKE, "--workers", "2", "--out", out, work="quick"),
        env=environment(),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_, bytes_)),
    )
    stopped(done)
    finished = rows(out)
    again = ended(*SMOKE, "--workers", "2", "--out", out, work="quick")
    assert again.returncode == 0, again.stderr
    assert finished.items() <= rows(out).items()
    same_run(out, trained / "run")


def stopped(done: subprocess.CompletedProcess[str]) -> None:
    """It says in one line that it cannot write, and blames no design."""
    assert done.returncode in (1, 2), done.stderr
    assert done.stderr.startswith("robomore: ") and done.stderr.count("\n") == 1, done.stderr
    assert "candidates failed" not in done.stderr
    assert "fault of RoboMoRe" not in done.stderr
    assert "write" in done.stderr or "space" in done.stderr or "disk" in done.stderr, done.stderr


READ_ONLY = textwrap.dedent(
    """
    import ctypes, importlib, os, sys
    from robomore.cli import main
    from robomore.sandbox.call import Containment
    from robomore.sandbox.linux import landlock
    # It cannot start the process that would try the layers out.
    run = importlib.import_module("robomore.experiment.run")
    run.choose_containment = lambda asked, ours: (Containment.STRICT, "")
    ctypes.CDLL(None).prctl(38, 1, 0, 0, 0)  # no new privileges
    landlock.WRITE |= 0x30  # our own commands may remove their temporary files and folders
    landlock.restrict(["/"], [os.environ["TMPDIR"], "/dev/null"])
    sys.exit(main())
    """
)


def read_only(tmp_path: Path, *arguments: str | Path) -> Said:
    """Run a command that cannot write but to a folder for temporary files; holds for root too."""
    elsewhere = tmp_path / "temporary"
    elsewhere.mkdir(exist_ok=True)
    done = subprocess.run(
        [sys.executable, "-c", READ_ONLY, *map(str, arguments)],
        env={**environment(), "TMPDIR": str(elsewhere)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert not list(elsewhere.iterdir()), "copies were left behind"
    return Said(done.returncode, done.stdout, done.stderr)


@strictly
@pytest.mark.parametrize("log", ["none", "empty", "killed"])
def test_a_run_on_a_read_only_medium_can_be_looked_at(
    log: str, undisturbed: Path, tmp_path: Path, robomore_: Command
) -> None:
    out = tmp_path / "run"
    if log == "killed":
        killed_run(out, 3)
    else:
        shutil.copytree(undisturbed, out)
        for path in out.glob("ledger.sqlite-*"):
            path.unlink()
    if log == "empty":
        (out / "ledger.sqlite-wal").write_bytes(b"")
    for path in out.glob("ledger.sqlite-shm"):
        path.unlink()
    shown = read_only(tmp_path, "show", out, "--json")
    assert shown.status == 0, shown.err
    assert facts(shown.out) == facts(robomore_("show", out, "--json").out)
    count = sum(json.loads(shown.out)["evaluations"].values())
    assert count == len(rows(out)) >= 3


@strictly
@pytest.mark.parametrize("there", [True, False])
def test_a_run_is_not_started_where_it_cannot_be_written(
    there: bool, undisturbed: Path, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    if there:
        shutil.copytree(undisturbed, out)
    said = read_only(tmp_path, *SMOKE, "--out", out)
    refused(said, "made read-only")
    assert "cannot write" in said.err
    if there:
        refused(read_only(tmp_path, "report", out), "made read-only")


def test_a_ledger_on_a_full_disk_is_not_called_damaged(small_disk: Path) -> None:
    resize(small_disk, "size=4k")
    with pytest.raises(Exception, match="free disk space"):
        Ledger(small_disk / "ledger.sqlite")


def test_a_worker_that_cannot_write_is_no_fault_of_the_designs(
    small_disk: Path, robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluator, "_WORK", "quick_run:disk_full")
    resize(small_disk, "size=3m")
    out = small_disk / "run"
    said = robomore_(*SMOKE, "--out", out)
    refused(said, "full for workers", status=1)
    assert "No space left" in said.err
    assert not rows(out)


def test_where_there_is_space_the_fault_is_ours_and_is_told(
    tmp_path: Path, robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluator, "_WORK", "quick_run:disk_full")
    out = tmp_path / "run"
    said = robomore_(*SMOKE, "--out", out)
    assert said.status == 1 and said.err.count("\n") == 1, said.err
    assert "all 2 candidates failed (2 failed)" in said.err and "No space left" in said.err
    shown = robomore_("show", out)
    assert shown.status == 0 and "2 failed" in shown.out and "nothing has been trained" in shown.out
    assert robomore_("report", out).status == 0


def test_a_probe_finds_a_full_disk(small_disk: Path) -> None:
    with pytest.raises(Exception, match=r"No space left.*same command"):
        RunFolder(small_disk).ensure_writable()
    assert not list(small_disk.iterdir())
    resize(small_disk, "size=64m")
    RunFolder(small_disk).ensure_writable()
