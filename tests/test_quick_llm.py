"""`--preset quick` in full against a real llama.cpp server on loopback, over the command line.

The protocol is real, the designs are nonsense: the model's weights are random. By default nothing
is trained; the exhaustive tests train every design, which takes some six minutes of one core.
"""

from __future__ import annotations

import json
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from llm.llama import serve_llama
from robomore.cli import main
from robomore.search.final import stage as final_stage
from robomore.search.robomore import RoboMoReSettings
from robomore.settings import preset
from robomore.store import Ledger, LedgerExchanges, Manifest, RunFolder

pytest.importorskip("pydantic_ai")
pytest.importorskip("xllamacpp")
pytest.importorskip("gguf")


@pytest.mark.parametrize(
    "executor", ["untrained", pytest.param("processes", marks=pytest.mark.exhaustive)]
)
def test_a_model_behind_a_real_server_designs_a_whole_quick_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], executor: str
) -> None:
    out = tmp_path / "run"
    with serve_llama(tmp_path) as url:
        status = main(
            [
                *("run", "swimmer", "--preset", "quick", "--designer", "llm", "--seed", "1"),
                *("--base-url", url, "--model", "random", "--temperature", "1.5"),
                *("--quiet", "--json", "--out", str(out), "--executor", executor),
            ]
        )
    said, errors = capsys.readouterr()
    assert status == 0, errors
    told = json.loads(said)

    # It was the preset as it is.
    folder = RunFolder(out)
    settings = Manifest.load(folder.manifest).settings
    assert settings == preset("quick")
    sizes = RoboMoReSettings(**settings.method.options)

    # Proposals arrived in every slot, and bad ones were sent back or replaced.
    with closing(LedgerExchanges(folder.ledger, read_only=True)) as log:
        exchanges = log.all()
    accepted = Counter(
        (one.slot.stage, one.slot.kind) for one in exchanges if one.validation_errors == ()
    )
    assert accepted["coarse", "morphology"] == sizes.proposed_morphologies
    assert accepted["coarse", "reward"] == sizes.proposed_rewards
    # A branch ends after a cycle of two turns that improved nothing.
    assert accepted["fine", "morphology"] >= 1
    assert accepted["fine", "morphology"] + accepted["fine", "reward"] >= 2
    assert sum(accepted.values()) < len(exchanges)
    assert all(one.validation_errors is not None for one in exchanges)
    assert all(one.structured for one in exchanges if one.slot.kind == "morphology")
    assert told["empty_slots"] == [] and told["cost"]["requests"] >= len(exchanges)

    # Candidates trained, and one is the champion.
    with closing(Ledger(folder.ledger, read_only=True)) as ledger:
        placed = Counter(place.stage for place, _ in ledger.placed())
    assert placed["coarse"] == sizes.morphologies * sizes.rewards
    assert placed["fine"] == accepted["fine", "morphology"] + accepted["fine", "reward"]
    assert placed["final"] == final_stage(settings.final).evaluations
    assert told["final"] and told["champion"]["efficiency"] is not None
    assert set(told["evaluations"]) == {"ok"}
    files = ["design.json", "reward.py", "robot.xml"]
    for name in [*files, "policy.npz"] if executor == "processes" else files:
        assert (folder.champion / name).is_file(), name
    assert folder.report.is_file()
