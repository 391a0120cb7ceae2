"""Whole runs with a language model on loopback: repaired, killed, resumed, replayed; and no key."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import zlib
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from exhaustive import more_of
from llm.loopback import KEY, Script, serve
from remembered import remembered_dry_runs  # noqa: F401
from robomore.designers import LanguageModel, Replay
from robomore.designers.llm.designer import LLMSettings
from robomore.designers.llm.history import HistorySettings
from robomore.errors import BudgetExhausted, InputError, ModelUnavailable, RunFolderError
from robomore.executors import Done
from robomore.executors.processes import Processes
from robomore.experiment import run
from robomore.llm import Exchange, ModelBudget, Sampling, Spending, connect
from robomore.llm.providers import COMPATIBLE_KEY
from robomore.llm.retry import RetryPolicy
from robomore.plan import Plan
from robomore.rewards.dry_run import DryRun
from robomore.runs import Run, load_run
from robomore.settings import RunSettings, with_method
from robomore.store import Ledger, LedgerExchanges, Manifest, RunFolder
from robomore.tasks import get_task
from robomore.types import Design, Morphology, Reward
from tiny import TINY, numbers

pytest.importorskip("pydantic_ai")

SETTINGS = LLMSettings(repairs=1)


def body(scale: float) -> tuple[str, str]:
    values = {
        p.name: round(p.reference * (scale if p.name.endswith("radius") else 1.0), 5)
        for p in get_task("swimmer").parameters
    }
    said = {"parameters": values, "description": f"{scale:g} times as thick"}
    return "say", json.dumps(said)


def program(line: str) -> tuple[str, str]:
    return "say", f"```python\ndef _get_rew(self, x_velocity, action):\n    {line}\n```"


GOOD = program("return x_velocity, {'speed': x_velocity}")
OTHER = program("return 2 * x_velocity - 0.1, {'speed': 2 * x_velocity, 'rent': -0.1}")
KINDS = ("morphology", "reward")
CONVERSATION: list[str | tuple[str, str]] = [
    ("say", "I would rather not."),
    body(0.8),
    body(0.8),  # a second time
    body(100.0),  # out of bounds, and out of repairs
    body(0.6),
    program("return float('nan'), {}"),
    GOOD,
    body(0.7),
    OTHER,
    "wrong_path",  # nobody asks for more
]
"""What the server says to a run of `TINY` with one repair, in order."""


ONCE = RetryPolicy(max_tries=1)


def talk(
    out: Path,
    url: str,
    retry_policy: RetryPolicy = ONCE,
    settings: RunSettings = TINY,
    executor: str = "untrained",
    **options: object,
) -> Path:
    model = connect("toy", base_url=url, retry_policy=retry_policy)
    chosen = LanguageModel(model, SETTINGS, server=url, **options)  # type: ignore[arg-type]
    return run(
        "swimmer", settings, designer=chosen, seed=1, executor=executor, workers=2, out=out
    ).folder


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(COMPATIBLE_KEY, KEY)


@pytest.fixture(scope="module")
def spoken(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Script]:
    """A finished run about evaluations that cost nothing; the server is gone."""
    with pytest.MonkeyPatch.context() as patch, serve(*CONVERSATION) as (url, script):
        patch.setenv(COMPATIBLE_KEY, KEY)
        return talk(tmp_path_factory.mktemp("llm") / "spoken", url), script


@pytest.fixture
def drafted(spoken: tuple[Path, Script]) -> Path:
    return spoken[0]


def exchanges(folder: Path) -> list[Exchange]:
    with closing(LedgerExchanges(RunFolder(folder).ledger, read_only=True)) as log:
        return log.all()


def test_bad_answers_are_repaired_or_replaced_and_a_champion_comes_out(
    spoken: tuple[Path, Script],
) -> None:
    folder, script = spoken
    assert (folder / "champion" / "design.json").is_file()
    assert load_run(folder).final
    kept = exchanges(folder)
    assert len(script.seen) == len(kept) == len(CONVERSATION) - 1
    asked = [(str(one.slot), one.slot.attempt, one.repair) for one in kept]
    assert asked == [
        ("coarse morphology 1", 0, 0),
        ("coarse morphology 1", 0, 1),
        ("coarse morphology 2", 0, 0),
        ("coarse morphology 2", 0, 1),
        ("coarse morphology 2", 1, 0),
        ("coarse reward 1", 0, 0),
        ("coarse reward 1", 0, 1),
        ("fine morphology 1.1", 0, 0),
        ("fine reward 1.1", 0, 0),
    ]
    found = [" ".join(one.validation_errors or ()) for one in kept]
    for number, word in enumerate(("JSON", "", "same morphology", "", "", "nan", "", "", "")):
        assert word in found[number]
    assert [bool(said) for said in found] == [True, False, True, True, False, True, *[False] * 3]
    # Errors went back to the model, and the fine stage saw what was measured.
    assert "when tried out" in script.seen[6]["messages"][-1]["content"]
    assert "efficiency" in script.seen[8]["messages"][1]["content"]
    with closing(Ledger(RunFolder(folder).ledger, read_only=True)) as ledger:
        assert [p.failure[:9] for p in ledger.proposals() if p.failure] == ["no usable"]


def test_no_key_is_written_anywhere(spoken: tuple[Path, Script]) -> None:
    folder, script = spoken
    assert set(script.keys) == {f"Bearer {KEY}"}
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert len(files) > 5
    assert not [path for path in files if KEY.encode() in path.read_bytes()]


def test_a_replay_is_the_run_to_the_last_digit(drafted: Path, tmp_path: Path) -> None:
    again = run(
        "swimmer",
        TINY,
        designer=Replay(drafted),
        seed=1,
        executor="untrained",
        out=tmp_path / "again",
    ).folder
    assert numbers(again) == numbers(drafted)
    before, after = exchanges(drafted), exchanges(again)
    assert [one.key for one in after] == [one.key for one in before]
    assert [one.validation_errors for one in after] == [one.validation_errors for one in before]
    assert {one.cost for one in after} == {0.0}
    assert load_run(again).spending.requests == 0
    assert "as recorded in" in Manifest.load(RunFolder(again).manifest).provenance


def test_a_replay_of_another_search_says_where_it_parts(drafted: Path, tmp_path: Path) -> None:
    other = replace(TINY, objective="fitness")
    with pytest.raises(InputError, match="another prompt for coarse morphology 1"):
        run(
            "swimmer",
            other,
            designer=Replay(drafted),
            seed=1,
            executor="untrained",
            out=tmp_path / "other",
        )


def test_by_slot_another_trainer_gets_the_same_proposals(drafted: Path, tmp_path: Path) -> None:
    trainer = replace(TINY.trainer, options={**TINY.trainer.options, "actor_lr": 3e-4})
    other = replace(TINY, trainer=trainer)
    folder = run(
        "swimmer",
        other,
        designer=Replay(drafted, "slot"),
        seed=1,
        executor="untrained",
        out=tmp_path / "o",
    ).folder
    assert numbers(folder) != numbers(drafted)
    replies = {(one.slot, one.repair): one.reply for one in exchanges(drafted)}
    assert all(replies[one.slot, one.repair] == one.reply for one in exchanges(folder))


def test_only_runs_of_a_model_can_be_replayed(tmp_path: Path) -> None:
    folder = tmp_path / "offline"
    manifest = Manifest(
        *("swimmer", {}, "custom", "offline", "No LLM was used.", 1, TINY), plan=Plan(())
    )
    RunFolder.prepare(folder, manifest).release()
    with pytest.raises(InputError, match="designed by 'offline'"):
        run(
            "swimmer",
            TINY,
            designer=Replay(folder),
            seed=1,
            executor="untrained",
            out=tmp_path / "again",
        )
    assert not (tmp_path / "again").exists()


@pytest.mark.exhaustive  # The next one is killed too, and its server fails besides.
def test_a_run_killed_again_and_again_pays_for_nothing_twice(drafted: Path, tmp_path: Path) -> None:
    program = textwrap.dedent(
        """
        import sys, msgspec
        from pathlib import Path
        sys.path.insert(0, sys.argv[3])
        from test_run_llm import talk
        from untrained import Untrained
        Untrained.seconds = 0.3
        talk(Path(sys.argv[1]), sys.argv[2])
        """
    )
    out = tmp_path / "killed"
    with serve(*CONVERSATION) as (url, script):
        command = [sys.executable, "-c", program, str(out), url, str(Path(__file__).parent)]
        # During the dry run of a reward, and in the fine stage.
        for kept in (6, 8):
            process = subprocess.Popen(command)
            _wait(lambda kept=kept: len(_so_far(out)) >= kept, process)
            process.send_signal(signal.SIGKILL)
            process.wait()
            assert len(script.seen) == kept, "killed too late to show anything"
        subprocess.run(command, check=True, timeout=300)
    assert len(script.seen) == len(exchanges(out)) == len(CONVERSATION) - 1
    assert numbers(out) == numbers(drafted)


def test_a_server_that_fails_in_every_way_and_a_run_killed_in_between(
    drafted: Path, tmp_path: Path
) -> None:
    """Nothing is lost, nothing is asked for twice, and what comes out is what always comes out."""
    faults = ("busy_for_a_second", "broken", "drop", "no_choices", "half", "page", "unavailable")
    steps: list[str | tuple[str, str]] = []
    killed_at = []
    for number, answer in enumerate(CONVERSATION[:-1]):
        steps += [faults[number % len(faults)]]
        if number in (4, 8):  # in the coarse stage and in the fine one
            # Stalled, the server has a request and has given no answer: the moment to be killed.
            killed_at.append(len(steps))
            steps.append("stall")
        if number == 5:
            steps.append("stall")  # this one is waited out
        steps.append(answer)
    program = textwrap.dedent(
        """
        import sys
        from pathlib import Path
        sys.path.insert(0, sys.argv[3])
        from robomore.llm.retry import RetryPolicy
        from test_run_llm import talk
        from untrained import Untrained
        talk(Path(sys.argv[1]), sys.argv[2], RetryPolicy(initial_wait=0.01, timeout=6.0))
        """
    )
    out = tmp_path / "out"
    with serve(*steps) as (url, script):
        command = [sys.executable, "-c", program, str(out), url, str(Path(__file__).parent)]
        for stalled in killed_at:
            process = subprocess.Popen(command)
            _wait(lambda stalled=stalled: len(script.seen) > stalled, process)
            process.send_signal(signal.SIGKILL)
            process.wait()
            answered = sum(isinstance(step, tuple) for step in steps[:stalled])
            assert len(_so_far(out)) == answered and len(script.seen) == stalled + 1
        subprocess.run(command, check=True, timeout=300)
    assert len(script.seen) == len(steps)
    assert [one.reply for one in exchanges(out)] == [text for _, text in CONVERSATION[:-1]]
    assert numbers(out) == numbers(drafted)
    # Every request counts, those in vain and those under way at a kill among them.
    assert load_run(out).spending.requests == len(steps)


BROAD = with_method(TINY, options={"morphologies": 3, "rewards": 2, "survivors": 0.5})
"""Three branches."""


class Thoughtful:
    """A server's answers: each follows from the request alone. Counts how many it gives at once."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.gate = threading.Event()
        self.gate.set()
        self.under_way: list[dict[str, Any]] = []
        self.most = {"coarse": 0, "fine": 0}

    def __call__(self, asked: dict[str, Any]) -> str:
        said = json.dumps(asked["messages"])
        stage = "fine" if "The best so far" in said else "coarse"
        with self.lock:
            self.under_way.append(asked)
            self.most[stage] = max(self.most[stage], len(self.under_way))
        time.sleep(0.1)
        if stage == "fine":
            self.gate.wait(60)
        with self.lock:
            self.under_way.remove(asked)
        number = zlib.crc32(said.encode())
        if "response_format" in asked:
            return body(0.5 + number / 2**33)[1]
        # Each reward is a fault at first.
        if len(asked["messages"]) == 2:
            return "Let me think."
        return program(f"return {number} * x_velocity, {{'speed': x_velocity}}")[1]


@pytest.mark.parametrize("diversity", more_of([True, False], True))
def test_side_by_side_or_in_turn_the_run_is_the_same(tmp_path: Path, diversity: bool) -> None:
    found = []
    settings = replace(SETTINGS, diversity=diversity)
    for parallel in (1, 3):
        mind = Thoughtful()
        with serve(mind) as (url, script):
            chosen = LanguageModel(
                connect("toy", base_url=url), settings, server=url, parallel=parallel
            )
            out = run(
                "swimmer",
                BROAD,
                designer=chosen,
                seed=1,
                executor="untrained",
                out=tmp_path / str(parallel),
            ).folder
        assert mind.most == {
            "coarse": 1 if diversity or parallel == 1 else 3,
            "fine": parallel,
        }
        kept = sorted((one.key, one.reply, one.validation_errors) for one in exchanges(out))
        assert len(kept) == len(script.seen)
        found.append((numbers(out), kept))
    assert found[0] == found[1]


@pytest.mark.exhaustive  # As the next but one, with SIGKILL and several at once.
def test_killed_with_several_answers_under_way_only_those_are_asked_for_again(
    tmp_path: Path,
) -> None:
    program = textwrap.dedent(
        """
        import sys
        from pathlib import Path
        sys.path.insert(0, sys.argv[3])
        from test_run_llm import BROAD, talk
        talk(Path(sys.argv[1]), sys.argv[2], settings=BROAD, parallel=3)
        """
    )
    mind = Thoughtful()
    with serve(mind) as (url, script):
        whole = talk(tmp_path / "whole", url, settings=BROAD)
        once = len(script.seen)
        mind.gate.clear()
        out = tmp_path / "killed"
        command = [sys.executable, "-c", program, str(out), url, str(Path(__file__).parent)]
        process = subprocess.Popen(command)
        _wait(lambda: len(mind.under_way) == 3, process)
        process.send_signal(signal.SIGKILL)
        process.wait()
        kept = len(_so_far(out))
        assert len(script.seen) == once + kept + 3
        mind.gate.set()
        subprocess.run(command, check=True, timeout=300)
        assert len(script.seen) == 2 * once + 3
    assert numbers(out) == numbers(whole)
    assert load_run(out).spending.requests == once + 3


def test_ctrl_c_does_not_wait_for_a_silent_server_and_the_run_goes_on(tmp_path: Path) -> None:
    """Branches ask from threads; none of them may keep the program from ending."""
    out = tmp_path / "out"
    mind = Thoughtful()
    mind.gate.clear()
    with serve(mind) as (url, script):
        command = [sys.executable, "-c", INTERRUPTED, str(out), url, str(Path(__file__).parent)]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        _wait(lambda: len(mind.under_way) == mind.most["fine"] == 3, process)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=30)
        assert process.returncode == 130, said
        assert said.startswith("robomore: stopped; 12 evaluations are kept")
        assert said.count("\n") == 1
        asked = len(script.seen)
        mind.gate.set()
        assert subprocess.run(command, check=False, timeout=300).returncode == 0
        # Those under way at the Ctrl-C were asked for again, and nothing else.
        assert len(script.seen) - asked >= 3
    assert len(exchanges(out)) == len(script.seen) - 3


def test_a_spent_budget_ends_the_run_and_a_larger_one_goes_on(
    tmp_path: Path,
) -> None:
    out = tmp_path / "poor"
    with serve(*CONVERSATION) as (url, script):
        with pytest.raises(BudgetExhausted, match="--max-requests"):
            talk(out, url, budget=ModelBudget(requests=3))
        assert len(script.seen) == 3
        with pytest.raises(BudgetExhausted):
            talk(out, url, budget=ModelBudget(requests=3))
        with pytest.raises(BudgetExhausted, match="--max-tokens"):
            talk(out, url, budget=ModelBudget(tokens=1_000))
        assert len(script.seen) == 3
        assert load_run(out).spending == Spending(requests=3, tokens=360)
        talk(out, url, budget=ModelBudget(requests=len(CONVERSATION) - 1, tokens=100_000, cost=1))
    assert load_run(out).final


def test_a_model_that_is_gone_ends_the_run_and_a_better_day_goes_on(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with serve(body(0.8), "broken", "wrong_key", "no_money", body(0.8), "page") as (url, script):
        with pytest.raises(ModelUnavailable, match="500"):
            talk(out, url)
        with pytest.raises(InputError, match="key was refused"):
            talk(out, url)
        with pytest.raises(InputError, match="quota"):
            talk(out, url)
        with pytest.raises(ModelUnavailable, match="web page"):
            talk(out, url)
    # The first body was asked for once; then each attempt went on from there.
    assert len(script.seen) == 6 and len(exchanges(out)) == 2


def test_another_model_or_another_use_of_it_is_another_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with serve(body(0.8), "broken") as (url, script):
        with pytest.raises(ModelUnavailable):
            talk(out, url)
        model = connect("toy", base_url=url)
        chosen = LanguageModel(model, SETTINGS, server=url)
        for other, said in (
            (replace(chosen, model=connect("other", base_url=url)), "model toy there"),
            (replace(chosen, server="http://elsewhere/v1"), "server"),
            (replace(chosen, vision=True), "vision"),
            (replace(chosen, settings=LLMSettings(repairs=2)), "repairs 1 there, 2 here"),
            (replace(chosen, settings=replace(SETTINGS, diversity=False)), "diversity"),
            (replace(chosen, settings=replace(SETTINGS, sampling=Sampling(0.1))), "sampling"),
            (replace(chosen, settings=replace(SETTINGS, history=HistorySettings(9))), "history"),
        ):
            with pytest.raises(RunFolderError, match=said):
                run("swimmer", TINY, designer=other, seed=1, out=out)
        assert len(script.seen) == 2


def test_a_limit_that_cannot_be_kept_is_refused_before_anything_is_written(
    tmp_path: Path,
) -> None:
    model = connect("toy", base_url="http://model.example/v1")
    chosen = LanguageModel(model, budget=ModelBudget(cost=1.0))
    with pytest.raises(InputError, match="--price"):
        run("swimmer", TINY, designer=chosen, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_is_secret_in_a_url_is_no_part_of_a_run() -> None:
    model = connect("toy", base_url="http://model.example/v1")
    chosen = LanguageModel(model, server="https://me:secret@model.example:8/v1?token=secret")
    assert chosen.identity["server"] == "https://model.example:8/v1"
    assert "secret" not in json.dumps(chosen.identity)


def test_pictures_go_along_where_the_model_can_see(tmp_path: Path) -> None:
    answers = (body(0.8), body(0.6), GOOD, body(0.7), "wrong_path")
    with (
        serve(*answers) as (url, script),
        pytest.raises(InputError, match="says HTTP 404"),
    ):
        talk(tmp_path / "out", url, vision=True)
    kinds = [[part["type"] for part in one["messages"][1]["content"]] for one in script.seen[3:]]
    assert kinds == [["text", "image_url"]] * 2
    assert all(isinstance(one["messages"][1]["content"], str) for one in script.seen[:3])


def test_no_key_reaches_a_worker_or_a_rewards_process(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "planted")
    monkeypatch.setenv(COMPATIBLE_KEY, "planted")
    monkeypatch.setenv("ROBOMORE_CACHE", str(tmp_path))
    tests = Path(__file__).parent
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, (tests / "executors", tests))))
    with closing(Processes(1)) as workers:
        ((_, seen),) = workers.map("jobs:environment", [b""], lambda *news: None, 30)
    assert isinstance(seen, Done)
    assert b"ROBOMORE_CACHE" in seen.reply and b"PATH" in seen.reply
    assert b"KEY" not in seen.reply
    curious = program("raise ValueError(sorted(__import__('os').environ))")[1]
    (found,) = DryRun(get_task("swimmer"), tmp_path)(curious.strip("`").removeprefix("python"))
    assert "'PATH'" in found.message and "KEY" not in found.message


@pytest.mark.exhaustive  # Designs are trained alike, whoever proposed them.
def test_designs_of_a_model_are_trained_and_one_is_the_champion(tmp_path: Path) -> None:
    """In earnest, but for the model (`test_quick_llm.py` has a real server)."""
    small = with_method(TINY, options={"morphologies": 1})
    with serve("page", body(0.8), "broken", GOOD, body(0.7), OTHER) as (url, _):
        retry_policy = RetryPolicy(initial_wait=0.01)
        chosen = LanguageModel(connect("toy", base_url=url, retry_policy=retry_policy), server=url)
        folder = run("swimmer", small, designer=chosen, seed=1, out=tmp_path / "run").folder
    accepted = [one for one in exchanges(folder) if one.validation_errors == ()]
    stages = [(one.slot.stage, one.slot.kind) for one in accepted]
    assert stages == [(stage, kind) for stage in ("coarse", "fine") for kind in KINDS]
    assert load_run(folder).final
    assert (folder / "champion" / "policy.npz").is_file()


INTERRUPTED = textwrap.dedent(
    """
    import signal, sys
    # A shell that starts programs in the background has them ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.path.insert(0, sys.argv[3])
    import untrained
    from robomore.cli import main
    sys.exit(main([
        "run", "swimmer", "--preset", "smoke", "--method-option", "morphologies=6", "--seed", "1",
        "--executor", "untrained",
        "--designer", "llm", "--base-url", sys.argv[2], "--model", "toy",
        "--out", sys.argv[1], "--quiet",
    ]))
    """
)


def _so_far(out: Path) -> list[Exchange]:
    return exchanges(out) if RunFolder(out).ledger.is_file() else []


def _wait(ready: Callable[[], bool], process: subprocess.Popen[bytes]) -> None:
    until = time.monotonic() + 120
    while time.monotonic() < until:
        assert process.poll() is None, "the run ended by itself"
        try:
            if ready():
                return
        except Exception as error:  # noqa: BLE001  # the ledger is just being made
            assert "nothing has been written" in str(error) or "cannot be used" in str(error)
        time.sleep(0.02)
    raise AssertionError("nothing happened")


def test_a_given_design_and_a_remark_go_into_a_run_and_are_kept(tmp_path: Path) -> None:
    swimmer = get_task("swimmer")
    mine = Design(
        Morphology(tuple(round(0.9 * value, 5) for value in swimmer.reference), "mine"),
        Reward(GOOD[1].removeprefix("```python\n").removesuffix("```"), "my reward"),
    )
    with serve(body(0.6), body(0.7), OTHER) as (url, script):
        model = LanguageModel(connect("toy", base_url=url, retry_policy=ONCE), SETTINGS, server=url)

        def start(**more: Any) -> Run:
            out, executor = tmp_path / "run", "untrained"
            given = {"start_from": [mine], "hint": "long and slow"} | more
            return run("swimmer", TINY, designer=model, seed=1, executor=executor, out=out, **given)

        found = start()
        asked = len(script.seen)
        with pytest.raises(RunFolderError, match="started from 1 given designs, others than"):
            start(start_from=[mine.morphology])
        again = start()
    assert len(script.seen) == asked == 3, "the first places are given ones, and all is known"
    assert again.champion == found.champion
    firsts = [p for p in found.proposals if not p.slot.improves and p.slot.index == (0,)]
    ideas = {(p.morphology or p.reward).idea for p in firsts}  # type: ignore[union-attr]
    assert ideas == {"given (start 1): mine", "given (start 1): my reward"}
    assert found.manifest.provenance.endswith("It started from start 1.")
    assert all("long and slow" in one.messages[-1].text for one in exchanges(found.folder))
    with closing(Ledger(RunFolder(found.folder).ledger, read_only=True)) as ledger:
        assert set(ledger.hints().values()) == {"long and slow"}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"hint": "faster"}, "offline reads no remarks"),
        ({"start_from": [Morphology((1.0,))]}, "start 1: swimmer: 1 parameters given"),
        ({"start_from": [Reward("import os")]}, "start 1: the reward cannot be used: line 1"),
        ({"start_from": [7]}, "cannot start from a int"),
    ],
)
def test_what_a_run_cannot_start_from_is_refused_before_anything_begins(
    options: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=said):
        run("swimmer", TINY, executor="untrained", out=tmp_path / "run", **options)
    assert not (tmp_path / "run").exists()
