"""How untrusted rewards are kept in, decided before a run starts."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from robomore import load_run, run
from robomore.errors import InputError
from robomore.experiment.containing import choose_containment
from robomore.sandbox import layers
from robomore.sandbox.call import Containment
from robomore.sandbox.restrictions import REQUIRED, Layer
from robomore.settings import preset, with_method


def test_only_rewards_of_our_own_may_do_without_layers(monkeypatch: pytest.MonkeyPatch) -> None:
    absent = [Layer(name, False, "not on this machine") for name in REQUIRED]
    found = [*absent, Layer("watchdog", True, "some")]
    monkeypatch.setattr(layers, "layers", lambda: found)
    monkeypatch.setattr(layers, "_all_hold", [])
    told = f"relaxed (watchdog; without {', '.join(REQUIRED)})"
    assert choose_containment(None, ours=True) == (Containment.RELAXED, told)
    assert choose_containment("relaxed", ours=False) == (Containment.RELAXED, told)
    for asked, ours in ((None, False), ("strict", True), ("strict", False)):
        with pytest.raises(InputError, match="--containment relaxed"):
            choose_containment(asked, ours)


def test_layers_are_tried_again_until_all_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    holding = [Layer(name, True, "") for name in REQUIRED]
    answers = [[Layer(name, False, "not now") for name in REQUIRED], holding]
    monkeypatch.setattr(layers, "layers", lambda: answers.pop(0))
    monkeypatch.setattr(layers, "_all_hold", [])
    assert choose_containment(None, ours=True)[0] is Containment.RELAXED
    for _ in range(3):
        assert choose_containment("strict", ours=False)[0] is Containment.STRICT
    assert not answers


def test_a_relaxed_run_keeps_a_trace_and_a_strict_one_has_nothing_to_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = Containment.RELAXED, "relaxed (limits; without files)"
    module = importlib.import_module("robomore.experiment.run")
    monkeypatch.setattr(module, "choose_containment", lambda asked, ours: chosen)
    settings = with_method(preset("smoke"), "random")
    run("swimmer", settings, executor="untrained", out=tmp_path / "relaxed")
    told = "Containment was relaxed (limits; without files)."
    assert load_run(tmp_path / "relaxed").warnings[0].startswith(told)
    assert told in (tmp_path / "relaxed" / "report.html").read_text()
    chosen = Containment.STRICT, "strict (limits, files)"
    run("swimmer", settings, executor="untrained", out=tmp_path / "strict")
    assert not any("Containment" in one for one in load_run(tmp_path / "strict").warnings)
