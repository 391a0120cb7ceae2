"""A run folder is taken by one run, and only by the run that it belongs to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from robomore.errors import RunFolderError
from robomore.plan import Plan, Stage
from robomore.settings import preset
from robomore.store import Manifest, RunFolder
from robomore.store.exchanges import LedgerExchanges
from robomore.store.ledger import Ledger
from robomore.store.schema import Proposal
from robomore.types import Morphology, Slot, Start

ASKED = Manifest(
    task="ant",
    task_parts={"template": "a1", "reward": "b2"},
    preset="smoke",
    designer="offline",
    provenance="No LLM was used.",
    seed=3,
    settings=preset("smoke"),
    plan=Plan((Stage(name="grid", axes=("morphology", "reward"), shape=(2, 2)),)),
)


def begun(path: Path, asked: Manifest) -> None:
    """Leave the folder of a run that has kept something."""
    folder = RunFolder.prepare(path, asked)
    (folder.artifacts / "0123").mkdir()
    folder.release()


def test_the_same_run_may_continue(tmp_path: Path) -> None:
    RunFolder.prepare(tmp_path / "run", ASKED).release()
    folder = RunFolder.prepare(tmp_path / "run", ASKED)
    assert Manifest.load(folder.manifest) == ASKED
    folder.release()


def test_what_a_killed_run_left_in_its_scratch_folder_is_removed(tmp_path: Path) -> None:
    begun(tmp_path / "run", ASKED)
    left = tmp_path / "run" / "scratch" / "k1" / "deep"
    left.mkdir(parents=True)
    with pytest.raises(RunFolderError):
        RunFolder.prepare(tmp_path / "run", replace(ASKED, seed=4))
    assert left.exists(), "of another run nothing is removed"
    folder = RunFolder.prepare(tmp_path / "run", ASKED)
    assert not list(folder.scratch.iterdir())
    folder.release()


def test_a_start_may_have_another_name_and_no_other_content(tmp_path: Path) -> None:
    def started(name: str, length: float) -> Manifest:
        morphology = Morphology((length,), f"given ({name})")
        return replace(ASKED, starts=(Start(name, morphology),))

    begun(tmp_path / "run", started("a.json", 1.0))
    RunFolder.prepare(tmp_path / "run", started("./b.json", 1.0)).release()
    with pytest.raises(RunFolderError, match="started from 1 given designs, others than"):
        RunFolder.prepare(tmp_path / "run", started("a.json", 2.0))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"task": "walker"}, "task is 'ant' there and 'walker' here"),
        ({"task_parts": {"template": "a2", "reward": "b2"}}, r"ant was edited since \(template\)"),
        ({"seed": 4}, "seed is 3 there and 4 here"),
        ({"designer": "llm"}, "designer is 'offline' there"),
        ({"settings": preset("quick"), "preset": "quick"}, "preset 'smoke'.*'quick'"),
        ({"versions": {"mujoco": "0"}}, "mujoco .* there, 0 here.*install those versions"),
    ],
)
def test_another_run_is_refused_with_the_difference(
    tmp_path: Path, change: dict[str, Any], said: str
) -> None:
    begun(tmp_path / "run", ASKED)
    with pytest.raises(RunFolderError, match=f"{said}.*") as refused:
        RunFolder.prepare(tmp_path / "run", replace(ASKED, **change))
    assert "--out" in str(refused.value)
    # A refusal does not keep the folder locked.
    RunFolder.prepare(tmp_path / "run", ASKED).release()


def test_a_run_that_kept_nothing_gives_way_to_another(tmp_path: Path) -> None:
    """A wrong URL of a model is corrected, and the same folder taken."""
    wrong = replace(ASKED, designer="llm", designer_settings={"server": "http://wrong"})
    folder = RunFolder.prepare(tmp_path / "run", wrong)
    Ledger(folder.ledger).close()
    LedgerExchanges(folder.ledger).close()
    folder.release()
    right = replace(wrong, designer_settings={"server": "http://right"})
    folder = RunFolder.prepare(tmp_path / "run", right)
    assert Manifest.load(folder.manifest) == right
    ledger = Ledger(folder.ledger)
    ledger.add_proposal(Proposal(Slot("coarse", "morphology", (0,)), Morphology((1.0,))), "abc")
    ledger.close()
    folder.release()
    with pytest.raises(RunFolderError, match="http://right there, http://wrong here"):
        RunFolder.prepare(tmp_path / "run", wrong)


@pytest.mark.parametrize("name", ["notes.txt", "checkpoints/mine.pt", "scratch/mine", "code/x.py"])
def test_a_folder_with_files_of_its_owner_is_refused_and_left_as_it_is(
    name: str, tmp_path: Path
) -> None:
    mine = tmp_path / name
    mine.parent.mkdir(exist_ok=True)
    mine.write_text("precious")
    with pytest.raises(RunFolderError, match=r"is not empty .* name a new folder with --out"):
        RunFolder.prepare(tmp_path, ASKED)
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [mine]
    assert mine.read_text() == "precious"


def test_a_run_that_ended_before_its_manifest_was_written_may_begin_again(tmp_path: Path) -> None:
    folder = RunFolder.prepare(tmp_path, ASKED)
    folder.release()
    folder.manifest.rename(tmp_path / ".run.json-1234.partial")
    RunFolder.prepare(tmp_path, ASKED).release()


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    held = RunFolder.prepare(tmp_path / "run", ASKED)
    with pytest.raises(RunFolderError, match="in use"):
        RunFolder.prepare(tmp_path / "run", ASKED)
    held.release()
    RunFolder.prepare(tmp_path / "run", ASKED).release()


def test_a_path_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunFolderError, match=r"cannot write.*--out"):
        RunFolder.prepare(tmp_path / "file" / "run", ASKED)


def test_a_damaged_manifest_is_refused(tmp_path: Path) -> None:
    folder = RunFolder.prepare(tmp_path / "run", ASKED)
    folder.release()
    folder.manifest.write_text(folder.manifest.read_text()[:-20])
    with pytest.raises(RunFolderError, match="damaged"):
        RunFolder.prepare(tmp_path / "run", ASKED)


@pytest.mark.parametrize(
    ("written", "changed"),
    [('"seed": 3', '"seed": 2'), ('"steps": 2048', '"steps": 2049'), ('"digest"', '"digesu"')],
)
def test_a_manifest_that_still_parses_is_not_believed(
    tmp_path: Path, written: str, changed: str
) -> None:
    folder = RunFolder.prepare(tmp_path / "run", ASKED)
    folder.release()
    text = folder.manifest.read_text()
    assert written in text
    folder.manifest.write_text(text.replace(written, changed, 1))
    with pytest.raises(RunFolderError, match="does not match its digest"):
        Manifest.load(folder.manifest)


def test_a_newer_manifest_is_refused(tmp_path: Path) -> None:
    folder = RunFolder.prepare(tmp_path / "run", ASKED)
    folder.release()
    text = folder.manifest.read_text().replace('"format": 3', '"format": 9')
    folder.manifest.write_text(text)
    with pytest.raises(RunFolderError, match=r"format 9.*newer"):
        Manifest.load(folder.manifest)


def test_a_folder_without_a_run_is_named(tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="not a run folder"):
        RunFolder.existing(tmp_path)
    (tmp_path / "ant-1").mkdir()
    (tmp_path / "hopper-1").touch()
    (tmp_path / "link").symlink_to("ant-1")
    for name, said in {
        "ant-2": r"no folder .*ant-2\. Did you mean '.*/ant-1'\? Name a folder that",
        "swimmer": r"no folder .*swimmer; name a folder that",
        "hopper-1": r"hopper-1 is a file; name a folder that",
        "link": r"link is not a run folder",
    }.items():
        with pytest.raises(RunFolderError, match=said):
            RunFolder.existing(tmp_path / name)


def test_a_plan_too_large_to_be_drawn_is_refused(tmp_path: Path) -> None:
    folder = RunFolder.prepare(
        tmp_path / "run",
        replace(ASKED, plan=Plan((Stage(name="grid", axes=("a", "b"), shape=(10**5, 10**5)),))),
    )
    folder.release()
    with pytest.raises(RunFolderError, match="more than 1,000,000 places"):
        Manifest.load(folder.manifest)


def test_a_lock_that_is_no_lock_is_named(tmp_path: Path) -> None:
    RunFolder.prepare(tmp_path / "run", ASKED).release()
    (tmp_path / "run" / "lock").write_bytes(b"no database at all" * 100)
    with pytest.raises(RunFolderError, match="remove that file"):
        RunFolder.prepare(tmp_path / "run", ASKED)


def test_what_a_killed_run_had_begun_to_write_is_removed(tmp_path: Path) -> None:
    out = tmp_path / "run"
    RunFolder.prepare(out, ASKED).release()
    left = [out / ".probe.partial-0a1b2c3d.partial", out / "artifacts" / ".a-00000000.partial"]
    kept = [out / ".report.html-0a1b2c3d.partial", out / ".notes"]
    for path in left + kept:
        path.write_bytes(b"")
    RunFolder.prepare(out, ASKED).release()
    assert not any(path.exists() for path in left)
    assert all(path.exists() for path in kept)
