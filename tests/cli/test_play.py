"""`play`: any trained design in motion, as a video where there is no screen."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from cli.commands import Command
from robomore.envs import opengl
from robomore.rendering import video
from robomore.rendering.recording import Recording
from robomore.runs import load_run


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


@pytest.mark.parametrize("part", ["", "champion", "champion/design.json"])
def test_play_writes_a_video_where_there_is_no_screen(
    robomore_: Command, trained_run: Path, tmp_path: Path, part: str
) -> None:
    out = tmp_path / "a.webp"
    said = robomore_("play", trained_run / part, "--seconds", "1", "--drawn", "--out", out)
    assert said.status == 0, said.err
    # What is told is what is shown, and not the whole episode of 40 s.
    assert "m forward in 1.00 s" in said.out and "drawn without" not in said.err
    from PIL import Image

    with Image.open(out) as video:
        assert video.size == (640, 360)
        assert getattr(video, "n_frames", 1) > 10


def test_a_video_lies_in_the_runs_folder_and_says_what_opengl_needs(
    robomore_: Command, trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opengl, "_works", lambda platform: False)
    monkeypatch.setattr(video, "_has_ffmpeg", lambda: False)
    monkeypatch.setattr(video, "_THIN", 0)  # whatever the search has found
    copy = tmp_path / "copy"
    shutil.copytree(trained_run, copy)
    refused = robomore_("play", copy, "--out", tmp_path / "a.mp4")
    assert refused.status == 2 and 'pip install "robomore[video]"' in refused.err
    said = robomore_("play", copy, "--beside", "--seconds", "1")
    assert said.status == 0, said.err
    assert "libosmesa6" in said.err and "Traceback" not in said.err
    assert said.out.count("m forward in 1.00 s") == 2
    from PIL import Image

    with Image.open(copy / "copy-champion-beside.webp") as made:
        assert made.size == (640, 720)


def test_play_takes_any_evaluation_and_the_reference(
    robomore_: Command, trained_run: Path, tmp_path: Path
) -> None:
    key = load_run(trained_run).searched[0].evaluation.key
    told = []
    for options in ([], ["--evaluation", key[:10]], ["--reference"]):
        said = robomore_(
            "play", trained_run, *options, "--seconds", "1", "--drawn", "--out", "a.gif"
        )
        assert said.status == 0, said.err
        told.append(said.out)
    assert len(set(told)) == 3


def test_a_policy_that_is_gone_is_named_with_a_remedy(
    robomore_: Command, trained_run: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(trained_run, copy)
    shutil.rmtree(copy / "artifacts")
    said = robomore_("play", copy)
    assert said.status == 2 and "has no policy" in said.err and said.err.count("\n") == 1
    (copy / "champion" / "policy.npz").unlink()
    assert robomore_("play", copy / "champion").status == 2


def test_a_window_shows_no_more_seconds_than_are_told(
    robomore_: Command, trained_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[float] = []

    def window(recording: Recording) -> bool:
        shown.append(recording.seconds)
        return True

    monkeypatch.setattr("robomore.cli.play._has_screen", lambda: True)
    monkeypatch.setattr("robomore.rendering.window.show_in_window", window)
    said = robomore_("play", trained_run, "--seconds", "1")
    assert "m forward in 1.00 s" in said.out and shown == pytest.approx([1.0])
