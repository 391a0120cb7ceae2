"""The command line of a language model: options, prompts, the check, estimates, exit statuses."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from llm.loopback import KEY, serve
from remembered import remembered_dry_runs  # noqa: F401
from robomore.cli import main
from robomore.cli.app import application
from robomore.cli.llm import ModelOptions, language_model
from robomore.designers import LanguageModel
from robomore.designers.llm.designer import LLMSettings
from robomore.designers.llm.prompting import KINDS, render_prompt
from robomore.experiment.training_facts import training_facts
from robomore.llm import Exchange, Sampling, connect
from robomore.llm.providers import COMPATIBLE_KEY
from robomore.llm.retry import RetryPolicy
from robomore.plan import Plan
from robomore.report.command import command_line
from robomore.runs import load_run
from robomore.settings import preset
from robomore.store import Manifest
from robomore.tasks import get_task
from test_run_llm import CONVERSATION, GOOD, OTHER, body, exchanges

pytest.importorskip("pydantic_ai")

exhaustive = pytest.mark.exhaustive

SMOKE = (
    *("run", "swimmer", "--preset", "smoke", "--seed", "1", "--executor", "untrained"),
    *("--reference-reward", "out", "--method-option", "rewards=1"),
)
"""A run whose grid is two morphologies and one reward, all proposed; nothing is trained."""
TINY = (*SMOKE, "--repairs", "1")
Said = tuple[int, str, str]
Command = Callable[..., Said]


@pytest.fixture
def robomore_(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Command:
    """Run a command in this process, without training and without waiting."""
    monkeypatch.setattr(RetryPolicy, "wait", lambda self, tried: 0.0)
    monkeypatch.setenv(COMPATIBLE_KEY, KEY)

    def run(*arguments: str | Path) -> Said:
        capsys.readouterr()
        status = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return status, out, err

    return run


def one_line(err: str) -> str:
    """Return the one line that a command ends with; before it, there are warnings alone."""
    *before, last = err.splitlines()
    assert all(line.startswith("robomore: warning: ") for line in before)
    return last


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of a model over the command line, and what it said."""
    out = tmp_path_factory.mktemp("cli") / "run"
    with serve(*CONVERSATION) as (url, _):
        server = ("--designer", "llm", "--base-url", url, "--model", "toy")
        assert main([*TINY, *server, "--quiet", "--out", str(out)]) == 0
    return out


def test_an_estimate_comes_before_the_first_request(robomore_: Command, tmp_path: Path) -> None:
    with serve("wrong_key") as (url, script):
        status, _, err = robomore_(
            *("run", "ant", "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--out", tmp_path / "out"),
        )
    first, *_, last = err.strip().splitlines()
    # Nine proposals, of which some need a repair; each may take 3 attempts of 4 answers.
    assert "takes about 11 requests" in first and "$0.00" in first
    assert "up to 108 requests if many answers are invalid" in first
    assert status == 2 and "key was refused" in last and KEY not in err
    assert COMPATIBLE_KEY in last
    assert len(script.seen) == 1


def test_a_spent_budget_is_one_line_and_the_same_command_goes_on(
    robomore_: Command, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with serve(*CONVERSATION) as (url, script):
        command = (
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--quiet", "--out", out),
        )
        status, _, err = robomore_(*command, "--max-requests", "4")
        assert status == 1 and len(script.seen) == 4
        assert err.startswith("robomore: the budget of 4 requests") and err.count("\n") == 1
        status, shown, err = robomore_("show", out)
        assert status == 0 and "language model: 4 requests, 480 tokens, $0.00" in shown
        status, shown, err = robomore_(*command, "--json")
    assert status == 0, err
    found = json.loads(shown)
    assert found["final"] and found["designer"] == "llm"
    assert found["cost"]["requests"] == len(script.seen) == len(CONVERSATION) - 1
    assert found["cost"]["tokens"] == 120 * len(script.seen) and found["cost"]["dollars"] == 0


def test_a_stubborn_slot_stays_empty_and_the_run_goes_on(
    robomore_: Command, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    refusals = [("say", f"I would rather not, {number}.") for number in range(6)]
    steps = [body(0.8), *refusals, GOOD, *refusals, OTHER]
    with serve(*steps) as (url, script):
        command = (
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--out", out, "--json"),
        )
        status, said, err = robomore_(*command)
        assert status == 0, err
        assert robomore_(*command)[0] == 0
        # Once in three attempts of two answers each, and never again.
        assert len(script.seen) == len(steps)
    told = json.loads(said)
    assert [one["slot"] for one in told["empty_slots"]] == [
        "coarse morphology 2",
        "fine morphology 1.1",
    ]
    reason = told["empty_slots"][0]["reason"]
    assert "no JSON object" in reason and "begins 'I would rather not, 5.'" in reason
    assert told["final"] and told["evaluations"] == {"ok": 6}
    assert "coarse morphology 2, attempt 3: no usable morphology in 2 answers" in err
    _, shown, _ = robomore_("show", out)
    assert "2 slots stayed empty" in " ".join(shown.split())
    assert "Slots that stayed empty" in (out / "report.html").read_text()


def test_a_model_that_fills_no_slot_ends_the_run_in_one_line(
    robomore_: Command, tmp_path: Path
) -> None:
    no_number = '{"parameters": ["a little"]}'
    with serve(("say", no_number)) as (url, script):
        command = (
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--quiet", "--out", tmp_path / "out"),
        )
        for _ in range(2):
            status, _, err = robomore_(*command)
            assert status == 1 and err.count("\n") == 1
            assert "filled none of 2 slots for a morphology" in err and "a little" in err
            assert len(script.seen) == 2 * 3 * 2
    status, shown, _ = robomore_("show", tmp_path / "out")
    assert status == 0 and "2 slots stayed empty" in " ".join(shown.split())


def test_a_model_that_does_not_answer_is_one_line(robomore_: Command, tmp_path: Path) -> None:
    with serve("broken") as (url, script):
        status, _, err = robomore_(
            *("run", "swimmer", "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--quiet", "--out", tmp_path / "out"),
        )
    assert status == 1 and len(script.seen) == RetryPolicy().max_tries
    assert "run the same command again" in one_line(err)


@pytest.mark.parametrize(
    ("fault", "tries", "exit_status", "said"),
    [
        ("drop", 6, 1, "before it had answered"),
        ("wrong_key", 1, 2, "the key was refused"),
        # What each of these means is decided, and tested, where the client is.
        pytest.param("busy_for_an_hour", 1, 1, "asks to wait 3600 s", marks=exhaustive),
        pytest.param("broken", 6, 1, "HTTP 500", marks=exhaustive),
        pytest.param("half", 6, 1, "cannot be read", marks=exhaustive),
        pytest.param("no_choices", 6, 1, "without content", marks=exhaustive),
        pytest.param("page", 6, 1, "sent a web page", marks=exhaustive),
        pytest.param("wrong_model", 1, 2, "no model of the name", marks=exhaustive),
    ],
)
def test_whatever_a_server_does_is_one_line_and_the_same_command_goes_on(
    robomore_: Command, tmp_path: Path, fault: str, tries: int, exit_status: int, said: str
) -> None:
    steps = [*CONVERSATION[:2], *[fault] * tries, *CONVERSATION[2:-1]]
    with serve(*steps) as (url, script):
        command = (
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--quiet", "--json", "--out", tmp_path / "out"),
        )
        status, out, err = robomore_(*command)
        assert (status, out) == (exit_status, "") and len(script.seen) == 2 + tries
        assert said in one_line(err) and KEY not in err
        status, out, err = robomore_(*command)
        assert status == 0, err
    # What was answered before the fault was not asked for again.
    assert len(script.seen) == len(steps) == json.loads(out)["cost"]["requests"]
    assert [one.reply for one in exchanges(tmp_path / "out")] == [
        step[1] for step in steps if isinstance(step, tuple)
    ]


def test_a_replay_over_the_command_line(robomore_: Command, finished: Path, tmp_path: Path) -> None:
    status, out, err = robomore_(
        *SMOKE,
        *("--designer", "replay", "--from", finished, "--out", tmp_path / "again", "--json"),
    )
    assert status == 0, err
    _, before, _ = robomore_("show", finished, "--json")
    mine, theirs = json.loads(out), json.loads(before)
    assert mine["champion"] == theirs["champion"] and mine["lineage"] == theirs["lineage"]


def test_what_the_settings_do_stands_in_the_ledger(
    robomore_: Command, finished: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with serve(("say", "no"), body(0.8), body(0.8), GOOD, body(0.7), OTHER) as (url, _):
        status, _, err = robomore_(
            *SMOKE,
            "--quiet",
            *("--designer", "llm", "--base-url", url, "--model", "toy", "--parallel", "1"),
            *("--no-diversity", "--repairs", "0", "--temperature", "0.7", "--out", out),
            *("--history-rule", "recent+worst", "--history-tokens", "10"),
        )
    assert status == 0, err
    usual, mine = exchanges(finished), exchanges(out)
    # Diversity Reflection: earlier proposals in the prompt, or a body said twice is no fault.
    assert [len(_with(run, "Earlier morphologies")) for run in (usual, mine)] == [3, 0]
    assert [one.reply for one in mine if one.validation_errors == ()].count(body(0.8)[1]) == 2
    # Repairs: a second answer in the same attempt, or a fresh attempt.
    assert {one.repair for one in usual} == {0, 1} and {one.repair for one in mine} == {0}
    assert [one.slot.attempt for one in mine] == [0, 1, 0, 0, 0, 0]
    # The history's rule is said in the prompt.
    said = "taken in turn (the latest; the worst by score)"
    assert [len(_with(run, said)) for run in (usual, mine)] == [0, 2]
    assert {one.sampling.temperature for one in mine} == {0.7}
    settings = Manifest.load(out / "run.json").designer_settings
    assert (settings["diversity"], settings["repairs"]) == (False, 0)
    assert settings["history"] == {"tokens": 10, "rule": "recent+worst"}
    # And `prompt` shows what such a run sends.
    assert (
        "Earlier morphologies"
        in robomore_("prompt", "swimmer", "morphology", "--from", finished)[1]
    )
    assert (
        "Earlier morphologies" not in robomore_("prompt", "swimmer", "morphology", "--from", out)[1]
    )


def _with(kept: list[Exchange], words: str) -> list[Exchange]:
    return [one for one in kept if words in one.messages[1].text]


def test_another_trainer_reuses_the_proposals_over_the_command_line(
    robomore_: Command, finished: Path, tmp_path: Path
) -> None:
    def replay(out: Path, *more: str) -> Said:
        return robomore_(
            *SMOKE,
            *("--designer", "replay", "--from", finished, "--trainer", "sac", *more),
            *("--trainer-option", "learning_starts=500", "--out", out, "--quiet", "--json"),
        )

    # Other numbers make other prompts, so by content the two runs part in the fine stage.
    status, _, err = replay(tmp_path / "content")
    assert status == 2 and "another prompt for coarse morphology 1" in err
    assert "replay it by slot" in err and err.count("\n") == 1
    status, out, err = replay(tmp_path / "slot", "--by", "slot")
    assert status == 0, err
    told = json.loads(out)
    assert told["final"] and told["cost"]["requests"] == 0
    mine, theirs = exchanges(tmp_path / "slot"), exchanges(finished)
    assert [(one.slot, one.repair, one.reply) for one in mine] == [
        (one.slot, one.repair, one.reply) for one in theirs
    ]
    assert Manifest.load(tmp_path / "slot" / "run.json").settings.trainer.name == "sac"


def test_a_replay_that_goes_further_than_the_recording_does_without(
    robomore_: Command, finished: Path, tmp_path: Path
) -> None:
    """Under another trainer a branch may still improve where the recorded one had ended."""
    command = (*SMOKE, "--json")
    replay = (*command, "--quiet", "--designer", "replay", "--from", finished, "--by", "slot")
    for number in range(1, 20):
        out = tmp_path / str(number)
        # Its numbers are made from its settings, so some trainer improves something.
        other = ("--method-option", "max_cycles=2", "--trainer-option", f"actor_lr={number}e-4")
        status, said, err = robomore_(*replay, *other, "--out", out)
        assert status == 0, err
        if (told := json.loads(said))["empty_slots"]:
            break
    assert [one["slot"] for one in told["empty_slots"]] == [
        "fine morphology 1.2",
        "fine reward 1.2",
    ]
    assert "2 slots stayed empty" in " ".join(told["warnings"])
    _, shown, _ = robomore_("show", out)
    assert "2 slots stayed empty" in " ".join(shown.split())
    # A grid that is larger than the recorded one is another matter.
    status, _, err = robomore_(
        *replay, "--method-option", "morphologies=3", "--out", tmp_path / "larger"
    )
    assert status == 2 and "ends before coarse morphology 3" in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--designer", "llm"), "--model PROVIDER:NAME"),
        (("--designer", "llm", "--model", "toy"), "not PROVIDER:NAME"),
        (("--designer", "llm", "--model", "openai:some"), "OPENAI_API_KEY is not set"),
        (("--designer", "replay"), "--from RUN"),
        (("--designer", "replay", "--from", "nowhere"), "there is no folder"),
        (("--model", "openai:some"), "add --designer llm"),
        (("--by", "slot"), "add --designer replay"),
        (("--designer", "llm", "--model", "a:b", "--price", "5"), "--price 5 is not IN,OUT"),
        (("--designer", "llm", "--model", "a:b", "--price", "1,x"), "is not IN,OUT"),
        (("--designer", "llm", "--model", "a:b", "--max-cost", "0"), "--max-cost is 0"),
        (("--designer", "llm", "--model", "a:b", "--repairs", "-1"), "less than 0"),
        (("--designer", "llm", "--model", "a:b", "--history-rule", "good"), "none of best"),
        (("--designer", "nobody"), "Choose one of offline, llm, replay"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(
    robomore_: Command,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    arguments: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    monkeypatch.chdir(tmp_path)
    status, out, err = robomore_("run", "ant", *arguments)
    assert (status, out) == (2, "") and said in err and err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_options_say_what_the_settings_say() -> None:
    made = language_model(ModelOptions(model="toy", base_url="http://127.0.0.1:1/v1"))
    assert made.settings == LLMSettings() and not made.vision
    assert not any(getattr(made.budget, one.name) for one in fields(made.budget))


def test_the_command_in_a_report_names_the_model_again(finished: Path) -> None:
    model = connect("toy", base_url="http://127.0.0.1:1/v1")
    settings = LLMSettings(diversity=False, repairs=1, sampling=Sampling(temperature=0.5))
    chosen = LanguageModel(model, settings, vision=True, server="http://127.0.0.1:1/v1")
    manifest = Manifest(
        task="ant",
        task_parts={},
        preset="quick",
        designer="llm",
        provenance="",
        seed=3,
        settings=preset("quick"),
        plan=Plan(()),
        designer_settings=chosen.identity,
    )
    run = load_run(finished)
    command = command_line(replace(run, manifest=manifest))
    assert command is not None
    words = shlex.split(command)
    assert "--history-tokens" not in words and "--designer llm" in command
    _, bound, _ = application().parse_args(words[1:], exit_on_error=False, print_error=False)
    assert language_model(bound.arguments["model"]).identity == chosen.identity
    replayed = replace(manifest, designer_settings={**chosen.identity, "replayed": "content"})
    assert command_line(replace(run, manifest=replayed)) is None


@pytest.mark.parametrize("kind", KINDS[:2])
def test_prompts_are_printed_as_they_are_sent(robomore_: Command, kind: str) -> None:
    status, out, _ = robomore_("prompt", "ant", kind)
    assert status == 0
    facts = training_facts(preset("quick"), get_task("ant"))
    for message in render_prompt(get_task("ant"), kind, training=facts):
        assert f"--- {message.role} ---\n{message.text}\n" in out
    assert ("--- schema ---" in out) == (kind == "morphology")


def test_the_prompts_of_a_run_are_those_that_were_sent(robomore_: Command, tmp_path: Path) -> None:
    out = tmp_path / "out"
    # The server is out of order just as the fine stage begins, so the next prompt is known.
    with serve(*CONVERSATION[:7], "broken") as (url, script):
        robomore_(
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--history-tokens", "900", "--quiet", "--out", out),
        )
    _, said, _ = robomore_("prompt", "swimmer", "improve-morphology", "--from", out, "--json")
    found = json.loads(said)
    sent = script.seen[-1]
    assert [m["text"] for m in found["messages"]] == [m["content"] for m in sent["messages"]]
    assert found["schema"] == sent["response_format"]["json_schema"]["schema"] | {
        "title": "morphology"
    }


def test_the_prompt_of_a_run_with_pictures_is_the_one_that_was_sent(
    robomore_: Command, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with serve(*CONVERSATION[:7], "broken") as (url, script):
        robomore_(
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--vision", "--quiet", "--out", out),
        )
    _, said, _ = robomore_("prompt", "swimmer", "improve-morphology", "--from", out, "--json")
    text, *pictures = script.seen[-1]["messages"][1]["content"]
    assert json.loads(said)["messages"][1]["text"] == text["text"] and pictures


def test_a_model_is_told_whose_training_was_cut_short(robomore_: Command, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with serve(*CONVERSATION[:7], "broken") as (url, script):
        robomore_(
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--method-option", "screening=halving", "--quiet", "--out", out),
            *("--trainer-option", "learning_starts=256"),
        )
    sent = script.seen[-1]["messages"]
    assert "| 20 % |" in sent[1]["content"]
    assert "A full training takes 2,048 steps" in sent[1]["content"]
    # What was stopped early stands in the table alone.
    assert sent[1]["content"].count("## Morphology") == 1
    # Screening compares bodies under the reference reward, which is nobody's business.
    assert get_task("swimmer").reward.split("\n")[2] not in sent[1]["content"]
    _, said, _ = robomore_("prompt", "swimmer", "improve-morphology", "--from", out, "--json")
    told = [message["text"] for message in json.loads(said)["messages"]]
    assert told == [message["content"] for message in sent]


def test_prompts_need_a_run_to_improve_on(robomore_: Command, finished: Path) -> None:
    status, _, err = robomore_("prompt", "ant", "improve-reward")
    assert status == 2 and "--from RUN" in err
    status, _, err = robomore_("prompt", "ant", "improve-reward", "--from", finished)
    assert status == 2 and "a run of 'swimmer'" in err
    for kind in KINDS:
        status, out, _ = robomore_("prompt", "swimmer", kind, "--from", finished)
        assert status == 0 and out


def test_the_check_tells_whether_a_model_can_design(robomore_: Command) -> None:
    with serve(("say", "ready"), ("say", '{"length": 2}')) as (url, script):
        status, out, _ = robomore_("llm", "check", "--base-url", url, "--model", "toy")
    assert status == 0 and len(script.seen) == 2
    assert "answers: ready" in out and "keeps to a JSON schema" in out and "240 tokens" in out
    with serve("thinking_only") as (url, _):
        status, out, _ = robomore_("llm", "check", "--base-url", url, "--model", "toy")
    assert status == 0 and "note:    the server sends answers as thoughts" in out
    with serve("broken") as (url, script):
        status, _, err = robomore_("llm", "check", "--base-url", url, "--model", "toy")
    assert status == 1 and len(script.seen) == 2 and "HTTP 500" in one_line(err)
    assert robomore_("llm", "check")[0] == 2


@pytest.mark.parametrize(
    ("steps", "shown", "said"),
    [
        (["cut_off"], "answers: {", "--max-output-tokens"),
        (["thinking_only", ("say", "no")], "answers: {", "(1) the server sent thoughts and no"),
        (["say"], "JSON:    no", """asked for {"length": 2.5}, it answered 'ready', which is no"""),
        ([("say", "no\x1b[2J" * 50)], "answers: no", "'no�[2Jno"),
        (["no_choices"], "", "look into the server's log"),
    ],
)
def test_a_check_that_finds_a_fault_names_it_and_fails(
    robomore_: Command, steps: list[Any], shown: str, said: str
) -> None:
    with serve(*steps) as (url, _):
        status, out, err = robomore_("llm", "check", "--base-url", url, "--model", "toy")
    assert status == 1 and shown in out
    assert said in one_line(err) and "run the same command" not in err
    assert len(err) < 400 and "\x1b" not in out + err


@pytest.mark.parametrize("fault", ["silent", "thinking_only", "cut_off"])
def test_a_run_that_gets_no_whole_answer_stops_early(
    robomore_: Command, tmp_path: Path, fault: str
) -> None:
    with serve(fault) as (url, script):
        status, _, err = robomore_(
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--quiet", "--out", tmp_path / "out"),
        )
    assert status == 1 and len(script.seen) == 4
    assert "gave 4 answers and none holds a whole design" in one_line(err)


@pytest.mark.parametrize(
    "answer", ["\n\x1b[2JI'm sorry,\tI can't help with that.\nIt is dangerous.", '{"sizes": [1]}']
)
def test_a_run_whose_model_never_answers_with_a_design_stops_early(
    robomore_: Command, tmp_path: Path, answer: str
) -> None:
    with serve(("say", answer)) as (url, script):
        status, _, err = robomore_(
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy"),
            *("--quiet", "--out", tmp_path / "out"),
        )
    assert status == 1 and len(script.seen) == 4
    assert "choose another model" in one_line(err) and "\x1b" not in err
    quoted = "I'm sorry, I can't help with that." if "sorry" in answer else '{"sizes": [1]}'
    assert quoted in one_line(err) and "dangerous" not in err


def test_a_server_that_never_sends_a_byte_ends_the_run_in_time(
    robomore_: Command, tmp_path: Path
) -> None:
    with serve("stall") as (url, script):
        status, _, err = robomore_(
            *(*TINY, "--designer", "llm", "--base-url", url, "--model", "toy", "--parallel", "1"),
            *("--answer-time", "0.5s", "--quiet", "--out", tmp_path / "out"),
        )
        assert status == 1 and len(script.seen) == 2
    assert "did not answer in time" in one_line(err) and "--answer-time" in one_line(err)


def test_a_time_for_an_answer_has_a_unit(robomore_: Command) -> None:
    status, _, err = robomore_("llm", "check", "--model", "ollama:toy", "--answer-time", "90")
    assert status == 2 and "--answer-time 90 has no unit; write 90s" in one_line(err)
