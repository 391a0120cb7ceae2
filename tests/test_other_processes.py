"""What a process inherits, and how its end is told."""

from __future__ import annotations

import pytest

from robomore.executors.worker_process import _how_it_ended
from robomore.processes import clean_environment, signal_name


def test_no_key_is_inherited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "sk-1")
    monkeypatch.setenv("HOME", "/home/somebody")
    assert clean_environment()["HOME"] == "/home/somebody"
    assert "sk-1" not in clean_environment().values()


@pytest.mark.parametrize("number", range(1, 65))
def test_every_signal_has_a_name(number: int) -> None:
    assert signal_name(number) in _how_it_ended(-number)


def test_signals_of_real_time_are_told_by_their_number() -> None:
    assert (signal_name(9), signal_name(40)) == ("SIGKILL", "signal 40")
