"""Options over a preset: applied, found again, and told in a name."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robomore.errors import InputError
from robomore.options import changes, settings_name, settings_words, with_options
from robomore.search import make_method
from robomore.settings import PRESETS, preset

COUNT = st.integers(1, 10**6)
TEXT = st.text("aZ9 =./\\-_\n\"'é\0", max_size=8)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**6), 10**6) | st.floats(-1e6, 1e6) | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=2),
    max_leaves=4,
)
OPTIONS = st.dictionaries(st.sampled_from(["morphologies", "learning_rate", "x"]), VALUES)
CHANGES = st.fixed_dictionaries(
    {},
    optional={
        "method": st.sampled_from(["robomore", "random", "someones"]),
        "method_options": OPTIONS,
        "trainer": st.sampled_from(["crossq", "sac"]),
        "trainer_options": OPTIONS,
        "steps": COUNT,
        "final_steps": COUNT,
        "finalists": COUNT,
        "final_seeds": COUNT,
        "evaluations": COUNT,
        "objective": st.sampled_from(["efficiency", "fitness", "transport-economy"]),
        "max_volume": st.floats(1e-6, 10),
        "max_density": st.floats(1, 1e6),
    },
)


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(name=st.sampled_from(sorted(PRESETS)), chosen=CHANGES)
def test_what_was_changed_is_found_again(name: str, chosen: dict[str, Any]) -> None:
    settings = with_options(preset(name), **chosen)
    found = changes(name, settings)
    assert found is not None
    # As a command says it: every value through JSON.
    assert with_options(preset(name), **json.loads(json.dumps(found))) == settings
    said = settings_name(name, settings)
    assert said.split("-")[0] == name
    assert len(said) <= 100
    assert not set(said) & set('/\\:*?"<>| \n\0')


@pytest.mark.parametrize(
    ("name", "chosen", "said"),
    [
        ("quick", {}, "quick"),
        ("quick", {"steps": 5_000}, "quick-steps5000"),
        ("quick", {"steps": 30_000}, "quick"),
        ("smoke", {"method": "random"}, "smoke-random"),
        ("quick", {"method_options": {"morphologies": 6}}, "quick-morphologies6"),
        ("standard", {"method_options": {"screening": "none"}}, "standard-screeningnone"),
        (
            "quick",
            {"trainer": "sac", "trainer_options": {"net_arch": [64, 64], "target_entropy": None}},
            "quick-sac-net_arch_64_64-target_entropynull",
        ),
        ("quick", {"final_seeds": 2, "objective": "fitness"}, "quick-final-seeds2-fitness"),
    ],
)
def test_a_name_tells_what_differs(name: str, chosen: dict[str, Any], said: str) -> None:
    assert settings_name(name, with_options(preset(name), **chosen)) == said


def test_long_names_are_cut_and_stay_apart() -> None:
    one = with_options(preset("quick"), method_options={"x": "a" * 300 + "1"})
    two = with_options(preset("quick"), method_options={"x": "a" * 300 + "2"})
    assert settings_name("quick", one) != settings_name("quick", two)


def test_the_finals_steps_keep_their_proportion() -> None:
    settings = with_options(preset("standard"), steps=1_000)
    assert (settings.candidate.steps, settings.final.steps) == (1_000, 2_000)
    assert with_options(preset("standard"), steps=1_000, final_steps=700).final.steps == 700


def test_another_method_or_trainer_starts_from_its_own_defaults() -> None:
    settings = with_options(preset("smoke"), method="random", trainer="sac")
    assert settings.method.options == {}
    assert settings.trainer.options == {}
    make_method(settings.method)
    kept = with_options(preset("smoke"), method_options={"rewards": 3}).method.options
    assert kept == {**preset("smoke").method.options, "rewards": 3}


@pytest.mark.parametrize("option", ["steps", "final_steps", "finalists", "final_seeds"])
def test_numbers_below_one_are_refused_by_name(option: str) -> None:
    with pytest.raises(InputError, match=f"--{option.replace('_', '-')} is 0; give"):
        with_options(preset("quick"), **{option: 0})


def test_an_unknown_objective_is_refused() -> None:
    with pytest.raises(InputError, match="Choose one of efficiency, fitness"):
        with_options(preset("quick"), objective="speed")  # type: ignore[arg-type]


def test_settings_that_no_option_reaches_are_custom() -> None:
    plain = preset("quick")
    own = replace(plain, final=replace(plain.final, episodes=3))
    assert changes("quick", own) is None
    assert settings_name("quick", own) == "custom"
    fewer = replace(plain, method=replace(plain.method, options={}))
    assert changes("quick", fewer) is None
    assert changes("nobodys", plain) is None


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "preset quick"),
        ({"method": "cmaes"}, "preset quick"),
        (
            {"steps": 20_000, "method_options": {"morphologies": 3, "max_cycles": 1}},
            "preset quick, with morphologies 3, max cycles 1, steps 20,000",
        ),
        ({"trainer": "sac", "objective": "fitness"}, ", with trainer sac, objective fitness"),
        ({"max_volume": 0.25, "require_audit": True}, ", with require audit, max volume 0.25"),
        (
            {"method": "given", "method_options": {"reward": "def _get_rew():\n", "x": None}},
            ", with reward of its own, x none",
        ),
        ({"method_options": {"x": False, "a\nb": [1]}}, ", with without x, a b of its own"),
    ],
)
def test_settings_are_said_as_a_preset_and_what_was_changed(
    options: dict[str, Any], said: str
) -> None:
    whole = with_options(preset("quick"), **options)
    assert settings_words(settings_name("quick", whole), whole).endswith(said)


def test_other_settings_are_said_by_their_name() -> None:
    plain = preset("quick")
    assert settings_words("comparison-random", plain) == "settings comparison-random"
    assert settings_words("custom", plain) == "custom settings"
    # A preset as it was in an older version: nobody has changed it.
    older = with_options(plain, steps=7)
    assert settings_words("quick", older) == "preset quick"
    budget = replace(older.final, episodes=3)
    own = replace(older, final=budget)
    assert settings_words("quick-steps7", own) == "settings quick-steps7"
    assert settings_words("quick", plain, 5_000) == "preset quick, with budget steps 5,000"
    assert settings_words("custom", plain, 5_000) == "custom settings, budget steps 5,000"


@settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow])
@given(chosen=CHANGES)
def test_settings_are_one_line(chosen: dict[str, Any]) -> None:
    whole = with_options(preset("quick"), **chosen)
    assert len(settings_words(settings_name("quick", whole), whole).splitlines()) == 1
