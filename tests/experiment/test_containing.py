"""How untrusted rewards are kept in, decided before a run starts."""

from __future__ import annotations

import pytest

from robomore.errors import InputError
from robomore.experiment.containing import choose_containment
from robomore.sandbox import layers
from robomore.sandbox.call import Containment
from robomore.sandbox.restrictions import REQUIRED, Layer


def test_only_rewards_of_our_own_may_do_without_layers(monkeypatch: pytest.MonkeyPatch) -> None:
    absent = [Layer(name, False, "not on this machine") for name in REQUIRED]
    found = [*absent, Layer("limits", True, "some")]
    monkeypatch.setattr(layers, "layers", lambda: found)
    monkeypatch.setattr(layers, "_all_hold", [])
    told = f"relaxed (limits; without {', '.join(REQUIRED)})"
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
