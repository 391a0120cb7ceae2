"""The sums of a design's files: what is changed, added or gone is noticed."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.errors import RunFolderError
from robomore.store.champion import SUMS, check_sums, write_sums


@pytest.fixture
def design(tmp_path: Path) -> Path:
    for name in ("design.json", "reward.py", "robot.xml"):
        (tmp_path / name).write_text(name)
    write_sums(tmp_path)
    return tmp_path


def test_what_was_written_is_right(design: Path) -> None:
    check_sums(design)
    (design / "champion.webp").write_bytes(b"a picture, which is no part of the design")
    check_sums(design)
    assert (design / SUMS).read_text().count("  ") == 3


def test_a_changed_file_is_named(design: Path) -> None:
    (design / "reward.py").write_text("another")
    with pytest.raises(RunFolderError, match=r"reward\.py does not match SHA256SUMS; restore it"):
        check_sums(design)


def test_a_missing_file_is_named(design: Path) -> None:
    (design / "robot.xml").unlink()
    with pytest.raises(RunFolderError, match=r"robot\.xml is missing"):
        check_sums(design)


def test_a_part_of_the_design_that_has_no_sum_is_named(design: Path) -> None:
    """A policy that somebody else put there would be played as the champion's."""
    (design / "policy.npz").write_bytes(b"another's")
    with pytest.raises(RunFolderError, match=r"policy\.npz does not match"):
        check_sums(design)


def test_sums_that_are_no_text_are_refused(design: Path) -> None:
    (design / SUMS).write_bytes(b"\xff\xfe")
    with pytest.raises(RunFolderError, match="cannot be read"):
        check_sums(design)


def test_a_folder_without_sums_is_its_owners(design: Path) -> None:
    (design / SUMS).unlink()
    (design / "reward.py").write_text("another")
    check_sums(design)
