"""Designers by name; those of other packages are found through entry points."""

from __future__ import annotations

import pytest

from robomore.designers import DESIGNERS, make_designer
from robomore.errors import InputError
from robomore.tasks.registry import TASKS


@pytest.mark.parametrize("name", DESIGNERS)
def test_designers_are_made_by_name_and_say_that_no_llm_was_used(name: str) -> None:
    designer = make_designer(name, TASKS["swimmer"], 0, "fitness")
    assert designer.name == name
    assert designer.provenance.startswith("No LLM was used: ")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ofline", "Did you mean 'offline'"),
        ("x", "offline, .*llm, replay"),
        ("llm", "needs --model"),
        ("replay", "needs --from"),
    ],
)
def test_a_designer_that_cannot_be_made_is_refused_with_the_remedy(name: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make_designer(name, TASKS["swimmer"], 0)


def test_other_packages_cannot_take_the_name_of_a_designer_with_settings() -> None:
    with pytest.raises(InputError, match="has the name of a designer of this package"):
        DESIGNERS.register("llm", DESIGNERS.get("offline"))
    with pytest.raises(InputError, match="is no function of task, seed and objective"):
        DESIGNERS.register("text", "not a function")  # type: ignore[arg-type]
