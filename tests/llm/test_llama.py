"""The designer against a real llama.cpp server (needs the optional packages)."""

from __future__ import annotations

from pathlib import Path

import pytest
from llama import serve_llama

from robomore.designers.llm.designer import LLMDesigner, LLMSettings
from robomore.designers.llm.history import HistorySettings
from robomore.llm import BudgetedClient, MemoryLog, Sampling, check, connect
from robomore.tasks import get_task
from robomore.types import Design, Evaluation, Job, Slot, Status, TrainerSettings

pytest.importorskip("pydantic_ai")
pytest.importorskip("xllamacpp")
pytest.importorskip("gguf")


def test_nonsense_designs_come_out_of_a_real_server(tmp_path: Path) -> None:
    task, log = get_task("swimmer"), MemoryLog()
    settings = LLMSettings(
        repairs=1, history=HistorySettings(500), sampling=Sampling(temperature=1.5, seed=1)
    )
    with serve_llama(tmp_path) as url:
        model = connect("random", base_url=url)
        made = LLMDesigner(task, BudgetedClient(model, log), settings)
        bodies = []
        for i in range(3):
            bodies.append(made.propose_morphology(Slot("coarse", "morphology", (i,)), bodies))
        programs = [made.propose_reward(Slot("coarse", "reward", (0,)), [])]
        job = Job("swimmer", Design(bodies[0], programs[0]), TrainerSettings(), 1, 1, 0)
        best = Evaluation("key", job, Status.OK, fitness=1.0, volume=0.1, efficiency=10.0)
        programs.append(
            made.improve_reward(Slot("fine", "reward", (0, 1), improves=True), best, [best])
        )
    assert len({body.parameters for body in bodies}) == 3
    assert all(task.check(body.parameters) and body.idea for body in bodies)
    assert len({program.source for program in programs}) == 2
    exchanges = log.all()
    assert sum(exchange.validation_errors == () for exchange in exchanges) == 5 < len(exchanges)
    assert all(
        exchange.input_tokens > 1000 and exchange.output_tokens > 5 for exchange in exchanges
    )
    assert all(exchange.structured for exchange in exchanges if exchange.slot.kind == "morphology")


def test_check_finds_a_real_server_that_answers(tmp_path: Path) -> None:
    with serve_llama(tmp_path) as url:
        result = check(connect("random", base_url=url), Sampling(max_output_tokens=20))
    assert result.tokens > 0 and result.cost == 0.0
