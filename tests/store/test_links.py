"""A run folder from somebody else: nothing in it leads to other files, and nothing hangs."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from fake_run import FakeRun, finished_run
from robomore.cli.trained_design import find_policies
from robomore.errors import InputError
from robomore.plain_files import PlainFolder
from robomore.report import write_report
from robomore.runs import load_run
from robomore.store import RunFolder


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> FakeRun:
    return finished_run(tmp_path_factory.mktemp("runs") / "run")


@pytest.fixture
def run(made: FakeRun, tmp_path: Path) -> Path:
    shutil.copytree(made.path, tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """What belongs to somebody else; its content is its own name."""
    folder = tmp_path / "outside"
    (folder / "inner").mkdir(parents=True)
    for name in ("file", "inner/file"):
        (folder / name).write_text(name)
    return folder


def untouched(outside: Path) -> bool:
    folder = PlainFolder(outside)
    return (
        folder.names() == ["file", "inner"]
        and folder.names("inner") == ["file"]
        and all(folder.read(name) == name.encode() for name in ("file", "inner/file"))
    )


NAMES = (
    *("run.json", "run.partial", "ledger.sqlite", "ledger.sqlite-wal", "ledger.sqlite-shm"),
    *("ledger.sqlite-journal", "ledger-damaged-1.sqlite", "ledger.partial", "lock", "lock-journal"),
    *("lock-wal", "report.html", "report.html.partial", "report-key001.html", "probe.partial"),
    *("artifacts", "checkpoints", "scratch", "champion", "champion.partial"),
    *("artifacts/key001", "artifacts/key001/policy.npz", "checkpoints/a", "checkpoints/a/arrays"),
    *("scratch/a", "champion/SHA256SUMS", "champion/design.json"),
)
"""What a run reads, writes or deletes."""

KINDS: dict[str, Callable[[Path, Path], object]] = {
    "link to a folder": lambda path, outside: path.symlink_to(outside),
    "link to a file": lambda path, outside: path.symlink_to(outside / "file"),
    "link to nothing": lambda path, outside: path.symlink_to(outside / "new"),
    "pipe": lambda path, outside: os.mkfifo(path),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_what_is_not_plain_is_refused_whatever_is_done_with_the_run(
    name: str, kind: str, run: Path, outside: Path, made: FakeRun
) -> None:
    path = run / name
    path.parent.mkdir(exist_ok=True)
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    KINDS[kind](path, outside)
    for use in (
        lambda: load_run(run),
        lambda: write_report(run),
        lambda: RunFolder.prepare(run, made.manifest),
        lambda: find_policies(run),
    ):
        if name == "run.json" and use is find_policies:
            continue
        with pytest.raises(InputError):
            use()
    assert untouched(outside)
    assert path.is_symlink() or path.is_fifo()


def test_the_run_folder_itself_may_be_reached_through_a_link(run: Path, tmp_path: Path) -> None:
    (tmp_path / "latest").symlink_to(run)
    assert load_run(tmp_path / "latest").champion is not None
    assert write_report(tmp_path / "latest").is_file()


def test_names_that_no_run_uses_are_nobodys_concern(run: Path, outside: Path) -> None:
    (run / "my notes").symlink_to(outside)
    assert load_run(run).champion is not None


def test_a_report_replaces_a_link_and_does_not_follow_it(run: Path, outside: Path) -> None:
    loaded = load_run(run)
    for name in ("page.html", "page.html.partial"):
        (run / name).symlink_to(outside / "file")
    with pytest.raises(InputError, match="symbolic link"):
        write_report(loaded, run / "page.html")
    (run / "page.html").unlink()
    assert write_report(loaded, run / "page.html").is_file()
    assert untouched(outside)


def test_a_ledger_that_shares_its_file_is_read_and_not_written(run: Path, made: FakeRun) -> None:
    os.link(run / "ledger.sqlite", run / "backup")
    assert load_run(run).champion is not None
    folder = RunFolder.prepare(run, made.manifest)
    folder.release()
    from robomore.store import open_or_recover

    with pytest.raises(InputError, match="hard link"):
        open_or_recover(folder.ledger)
