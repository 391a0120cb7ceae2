"""Whatever byte of a run's folder is damaged: it is noticed or without effect, never believed."""

from __future__ import annotations

import random
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from lives import killed_run
from quick_run import SMOKE
from refusals import Command, facts, measured, refused
from run_state import champion, numbers, rows

from exhaustive import more_of
from robomore.cli.trained_design import find_policies
from robomore.errors import InputError
from robomore.store import RunFolder


@pytest.mark.parametrize("place", more_of(range(50), *range(5)))
def test_a_damaged_file_is_refused_or_made_good(
    place: int, undisturbed: Path, tmp_path: Path, robomore_: Command
) -> None:
    choose = random.Random(place)
    out = tmp_path / "run"
    shutil.copytree(undisturbed, out)
    done = damage(choose.choice(targets(out)), choose)

    shown = robomore_("show", out, "--json")
    if shown.status == 0:
        assert facts(shown.out) == facts(robomore_("show", undisturbed, "--json").out), done
    else:
        refused(shown, done)
    shown_policy = found(out)
    assert shown_policy is None or shown_policy == found(undisturbed), done

    again = robomore_(*SMOKE, "--out", out)
    if again.status == 0:
        assert numbers(out) == numbers(undisturbed), done
        assert found(out) == found(undisturbed), done
        for name in ("design.json", "reward.py", "robot.xml"):
            assert champion(out)[name] == champion(undisturbed)[name], done
        shown = robomore_("show", out, "--json")
        assert measured(shown.out) == measured(robomore_("show", undisturbed, "--json").out), done
    else:
        refused(again, done)
    # A manifest has nothing to be made good from; all else has.
    assert again.status == 0 or "run.json" in done or "ledger" in done, again.err


@pytest.mark.parametrize("place", more_of(range(4), 0))
def test_a_damaged_log_of_a_killed_run_costs_what_was_last_written(
    place: int, undisturbed: Path, tmp_path: Path, robomore_: Command
) -> None:
    choose = random.Random(place)
    out = tmp_path / "run"
    done = damage(killed_run(out, 4), choose)
    before = robomore_("show", out, "--json")
    if before.status:
        refused(before, done)
    again = robomore_(*SMOKE, "--out", out)
    assert again.status == 0, f"{again.err} after {done}"
    assert numbers(out) == numbers(undisturbed), done
    assert champion(out) == champion(undisturbed), done


def test_an_empty_ledger_is_done_again(
    undisturbed: Path,
    tmp_path: Path,
    robomore_: Command,
    caplog: pytest.LogCaptureFixture,
) -> None:
    out = tmp_path / "run"
    shutil.copytree(undisturbed, out)
    RunFolder(out).ledger.write_bytes(b"")
    refused(robomore_("show", out), "emptied")
    assert robomore_(*SMOKE, "--out", out).status == 0
    assert "is empty" in caplog.text
    assert numbers(out) == numbers(undisturbed)


def test_a_recovered_ledger_keeps_what_is_whole(
    undisturbed: Path, tmp_path: Path, robomore_: Command, caplog: pytest.LogCaptureFixture
) -> None:
    out = tmp_path / "run"
    shutil.copytree(undisturbed, out)
    path = RunFolder(out).ledger
    before = rows(out)
    lost = sorted(before)[3]
    with closing(sqlite3.connect(path)) as db, db:
        db.execute("UPDATE evaluations SET body = x'7b7d' WHERE key = ?", (lost,))
    refused(robomore_("show", out), "a row changed")
    assert robomore_(*SMOKE, "--out", out).status == 0
    assert "rows are whole and kept" in caplog.text
    assert (out / "ledger-damaged-1.sqlite").is_file()
    after = rows(out)
    assert [key for key in before if after[key] != before[key]] == [lost]
    assert numbers(out) == numbers(undisturbed)


def test_a_policy_that_is_gone_is_trained_again_for_the_champion_alone(
    undisturbed: Path, tmp_path: Path, robomore_: Command
) -> None:
    out = tmp_path / "run"
    shutil.copytree(undisturbed, out)
    shutil.rmtree(RunFolder(out).artifacts)
    assert robomore_(*SMOKE, "--out", out).status == 0
    assert len(list(RunFolder(out).artifacts.iterdir())) == 1
    assert champion(out) == champion(undisturbed)
    assert rows(out) == rows(undisturbed)


def targets(out: Path) -> list[Path]:
    """Return what may be damaged, the ledger and the champion's policy more often."""
    folder = RunFolder(out)
    artifacts = sorted(folder.artifacts.glob("*/policy.npz"))
    crowned = [p for p in artifacts if p.read_bytes() == champion(out)["policy.npz"]]
    return [
        *[folder.ledger] * 8,
        *crowned * 3,
        *artifacts,
        *[folder.manifest] * 2,
        *sorted(folder.champion.iterdir()),
    ]


def damage(path: Path, choose: random.Random) -> str:
    """Cut a file off, flip some bits of one byte, or overwrite a sector; returns what was done."""
    content = bytearray(path.read_bytes())
    at = choose.randrange(len(content))
    match choose.choice(("cut", "flip", "flip", "sector")):
        case "cut":
            del content[at:]
            said = f"cut off at {at}"
        case "flip":
            content[at] ^= choose.randrange(1, 256)
            said = f"flipped at {at}"
        case _:
            sector = content[at : at + 512]
            content[at : at + 512] = choose.randbytes(len(sector))
            said = f"overwritten at {at}"
    path.write_bytes(content)
    return f"{path.parent.name}/{path.name} {said}"


def found(out: Path) -> tuple[Any, ...] | None:
    """Return what `play` would show, `None` where it refuses."""
    try:
        (shown,) = find_policies(out)
    except InputError:
        return None
    return shown.task.id, shown.parameters, shown.policy.to_bytes()
