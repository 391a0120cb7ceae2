"""Given designs are tried first, by every method that can start from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from fakes import CountingDesigner, context_of, evaluation

from robomore.designers.started import StartedDesigner
from robomore.errors import InputError
from robomore.experiment.run import default_folder
from robomore.experiment.starting import checked_starts
from robomore.plan import Plan, Stage
from robomore.search import METHODS, make_method
from robomore.search.starts import usable
from robomore.tasks import get_task
from robomore.types import Evaluation, MethodSettings, Morphology, Reward, Slot, Start, Trial

THICK = Morphology((1.0, 1.0, 1.0, 0.2, 0.2, 0.2), "given (mine.json)")
BEYOND = Morphology((1.0, 1.0, 1.0, 0.008, 0.8, 0.2), "beyond what samplers draw")
"""A start that is valid in the task and outside of its search ranges."""
MINE = Reward("def _get_rew(self, x_velocity, action):\n    return 1.0, {}\n", "mine")

WITHOUT_DESIGNER = ("random", "bayesian", "cmaes", "genetic", "map-elites")


class Measured:
    """Made-up measurements: the thicker the better."""

    def __init__(self) -> None:
        self.trials: list[Trial] = []

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        self.trials += trials
        return [evaluation(t.design, sum(t.design.morphology.parameters)) for t in trials]


@pytest.mark.parametrize("name", WITHOUT_DESIGNER)
def test_a_method_without_designer_tries_given_morphologies_first(name: str) -> None:
    measured = Measured()
    context = replace(context_of("swimmer", 12), starts=(THICK, BEYOND))
    method = make_method(MethodSettings(name))
    found = method.run(CountingDesigner(), measured, context)
    tried = [trial.design.morphology for trial in measured.trials]
    assert {THICK, BEYOND} <= set(tried[:3]), "the reference at most comes before them"
    assert len(tried) == len(found) == 12
    assert {trial.design.reward for trial in measured.trials} == {context.reference.reward}
    plain = Measured()
    make_method(MethodSettings(name)).run(CountingDesigner(), plain, context_of("swimmer", 12))
    assert THICK not in [trial.design.morphology for trial in plain.trials]


def test_named_starts_are_the_reference_and_its_thinnest_valid_version() -> None:
    task = get_task("half-cheetah")
    reference = checked_starts(task, ["reference"])[0].morphology
    assert reference and reference.parameters == task.reference
    slim = checked_starts(task, ["slim-reference"])[0].morphology
    assert slim
    changed = [
        (now / before, name)
        for name, now, before in zip(task.names, slim.parameters, task.reference, strict=True)
        if now != before
    ]
    assert changed and all("radius" in name for _, name in changed)
    scales = [scale for scale, _ in changed]
    assert max(scales) - min(scales) < 0.01 and max(scales) < 0.6
    with pytest.raises(InputError, match=r"'slim'; give .* one of the names reference, slim-ref"):
        checked_starts(task, ["slim"])


def test_a_designer_s_first_places_are_given_ones_and_the_rest_its_own() -> None:
    counting = CountingDesigner()
    designer = StartedDesigner(counting, [THICK], [MINE])
    assert designer.propose_morphology(Slot("coarse", "morphology", (0,)), ()) is THICK
    assert designer.propose_reward(Slot("iterations", "reward", (0, 0)), ()) is MINE
    own = designer.propose_morphology(Slot("coarse", "morphology", (1,)), (THICK,))
    assert own.parameters == (2.0,), "it sees the given one as an earlier proposal"
    assert [slot.index for slot in counting.asked] == [(1,)]
    assert (designer.name, designer.reflects) == ("counting", True)


def test_every_method_says_what_it_starts_from() -> None:
    methods = {name: make_method(MethodSettings(name)) for name in METHODS}
    takes = {name: getattr(method, "starts_from", ()) for name, method in methods.items()}
    both, one = ("morphology", "reward"), ("morphology",)
    assert {name: kinds for name, kinds in takes.items() if name != "given"} == {
        "robomore": both,
        "eureka": ("reward",),
        "eureka-morphology": one,
        "reference": (),
        "slim-reference": (),
        **dict.fromkeys(WITHOUT_DESIGNER, one),
    }


PLAN = Plan(
    (Stage(name="grid", proposals=(("propose", "morphology", 2), ("propose", "reward", 1))),)
)


def test_what_a_method_cannot_use_is_refused() -> None:
    starts = [Start("a.json", THICK), Start("run", BEYOND, MINE)]
    found = usable(starts, ("morphology", "reward"), PLAN, "robomore")
    assert found == ((THICK, BEYOND), (MINE,))
    assert usable(starts, ("morphology",), PLAN, "eureka-morphology") == ((THICK, BEYOND), ())
    with pytest.raises(InputError, match=r"a.json is a morphology.*'eureka' takes a reward"):
        usable(starts, ("reward",), PLAN, "eureka")
    with pytest.raises(InputError, match="the method 'reference' starts from the reference alone"):
        usable(starts, (), PLAN, "reference")
    with pytest.raises(InputError, match="2 starts have a reward, and this search tries 1"):
        others = [Start("a.py", None, MINE), Start("b.py", None, Reward(f"{MINE.source}\n"))]
        usable(others, ("reward",), PLAN, "robomore")


@pytest.mark.parametrize(
    ("without", "takes"), [("morphology", "takes a reward"), ("reward", "takes a morphology")]
)
def test_a_search_without_a_half_cannot_start_from_one(without: str, takes: str) -> None:
    method = make_method(MethodSettings("robomore", {"without": [without]}))
    plan = method.plan(context_of("swimmer", 4))
    half = {"morphology": Start("mine", THICK), "reward": Start("mine", None, MINE)}[without]
    with pytest.raises(InputError, match=f"mine is a {without}.*{takes}"):
        usable([half], method.starts_from, plan, "robomore")  # type: ignore[attr-defined]
    assert plan.proposals["propose", without] == 0
    # Of a whole design it takes the other half.
    kept = usable([Start("run", THICK, MINE)], method.starts_from, plan, "robomore")  # type: ignore[attr-defined]
    assert kept == (((), (MINE,)) if without == "morphology" else ((THICK,), ()))


@pytest.mark.parametrize(("name", "places"), [("random", 4), ("cmaes", 4), ("genetic", 3)])
def test_as_many_starts_are_taken_as_there_are_places(name: str, places: int) -> None:
    method = make_method(MethodSettings(name))
    context = context_of("swimmer", 4)
    starts = [
        Start(f"{n}.json", Morphology((1.0, 1.0, 1.0, 0.2, 0.2, 0.1 + 0.01 * n)))
        for n in range(places + 1)
    ]
    first = getattr(method, "reference_first", True)

    def taken(count: int) -> int:
        given, _ = usable(starts[:count], ("morphology",), method.plan(context), name, first)
        measured = Measured()
        method.run(CountingDesigner(), measured, replace(context, starts=given))
        return len(set(given) & {trial.design.morphology for trial in measured.trials})

    assert taken(places) == places
    with pytest.raises(InputError, match=f"{places + 1} starts .* tries {places} first ones"):
        taken(places + 1)


def test_what_is_given_twice_takes_one_place() -> None:
    again = Morphology(THICK.parameters, "given (copy.json)")
    starts = [Start("a.json", THICK), Start("copy.json", again, MINE), Start("a.py", None, MINE)]
    found = usable(starts, ("morphology", "reward"), PLAN, "robomore")
    assert found == ((THICK,), (MINE,))


def test_the_default_folder_tells_runs_with_other_starts_apart() -> None:
    asked = ("swimmer", "quick", "offline", 1)
    plain = default_folder(*asked)
    assert plain == Path("runs/swimmer-quick-offline-s1")
    starts = [Start("a.json", THICK)], [Start("a.json", BEYOND)], [Start("a.py", None, MINE)]
    folders = {default_folder(*asked, one) for one in starts}
    assert len(folders) == 3 and plain not in folders
    renamed = Start("./b.json", Morphology(THICK.parameters, "given (./b.json)"))
    assert default_folder(*asked, [renamed]) == default_folder(*asked, starts[0])
