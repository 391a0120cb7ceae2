"""`methods`: every method with its options, whoever wrote it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import msgspec
import pytest

from cli.commands import Command
from robomore.cli.methods import options_of
from robomore.search import METHODS


@dataclass(frozen=True, slots=True)
class Base:
    """Options that others add to."""

    size: Annotated[int, msgspec.Meta(ge=1, lt=9)] = 3
    """How many,
    over two lines."""


@dataclass(frozen=True, slots=True)
class Settings(Base):
    """Options of a method."""

    mode: Literal["fast", "slow"] = "fast"
    share: Annotated[float, msgspec.Meta(gt=0, le=1)] | None = None
    """A share."""
    sizes: tuple[int, ...] = (1, 2)
    """Sizes."""


def test_every_method_is_listed_with_every_option(robomore_: Command) -> None:
    said = robomore_("methods")
    found = robomore_("methods", "--json").json
    assert [one["name"] for one in found] == list(METHODS)
    for one in found:
        assert f"{one['name']}  {one['summary']}" in said.out
        options = METHODS.get(one["name"]).Settings.__dataclass_fields__
        assert [option["name"] for option in one["options"]] == list(options)
        assert all(option["meaning"] and option["type"] for option in one["options"])
    assert {one["name"]: one["needs_designer"] for one in found}["random"] is False


def test_options_are_told_from_their_class() -> None:
    size, mode, share, sizes = options_of(Settings)
    assert (size.name, size.type, size.default) == (
        "size",
        "whole number, at least 1, below 9",
        3,
    )
    assert size.meaning == "How many, over two lines."
    assert (mode.type, mode.meaning) == ("fast or slow", "")
    assert (share.type, share.default) == ("number, above 0, at most 1; or null", None)
    assert (sizes.type, sizes.default) == ("list, each whole number", (1, 2))


def test_a_method_written_in_no_file_has_options_without_meaning(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: dict[str, Any] = {}
    code = "from dataclasses import dataclass\n@dataclass\nclass Own:\n    size: int = 1\n"
    exec(code, made)

    class Method:
        Settings = made["Own"]
        summary: ClassVar[str] = "made up"
        needs_designer: ClassVar[bool] = False
        provenance: ClassVar[str] = ""
        plan = run = None

    monkeypatch.setattr(METHODS, "_items", {**METHODS._items, "own": Method})
    said = robomore_("methods")
    assert said.status == 0 and "size=1  (whole number)" in said.out
