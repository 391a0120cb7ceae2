"""`export`: a champion as files, a table, or both."""

from __future__ import annotations

from pathlib import Path

from cli.commands import Command


def test_export_on_the_command_line(
    robomore_: Command, trained_run: Path, finished: Path, tmp_path: Path
) -> None:
    table = tmp_path / "a.csv"
    files = ("--to", tmp_path / "a", "--no-video", "--scale", "0.05")
    said = robomore_("export", trained_run, *files, "--csv", table)
    assert said.status == 0, said.err
    assert table.read_text().count("\n") > 1
    assert "verdict" in said.out and "by the exported code alone" in said.out
    again = robomore_("export", trained_run, "--to", tmp_path / "a")
    assert again.status == 2 and "--force" in again.err
    for wrong in ([], ["--csv", "-", "--force"]):
        assert robomore_("export", trained_run, *wrong).status == 2
    missing = robomore_("export", finished, "--to", tmp_path / "b")
    assert missing.status == 2 and "has no policy" in missing.err
    assert not (tmp_path / "b").exists()
