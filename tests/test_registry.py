"""One registry for all kinds of plug-in: found, refused, and never in the way of the others."""

from __future__ import annotations

import importlib.metadata
import logging
from importlib.metadata import EntryPoint

import pytest

from robomore.errors import InputError
from robomore.registry import Registry


def fault(name: str, found: object) -> str:
    return "" if isinstance(found, int) else f"is a {type(found).__name__}, no number"


def numbers(monkeypatch: pytest.MonkeyPatch, **plugins: str) -> Registry[int]:
    entries = [EntryPoint(name, value, "numbers") for name, value in plugins.items()]
    monkeypatch.setattr(
        "robomore.registry.entry_points",
        lambda group: importlib.metadata.EntryPoints(entries if group == "numbers" else []),
    )
    return Registry("number", "numbers", {"one": 1, "maximum": "sys:maxsize"}, fault)


def test_items_are_found_by_name_wherever_they_come_from(monkeypatch: pytest.MonkeyPatch) -> None:
    found = numbers(monkeypatch, soft="errno:EPERM")
    found.register("two", 2)
    assert found["one"] == 1 and found.get("two") == 2 and found.get("soft") == 1
    assert found.get("maximum") > 2**31
    assert found.names() == ("one", "maximum", "two", "soft")
    assert "soft" in found and "three" not in found


def test_an_unknown_name_is_told_with_the_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        InputError, match=r"no number is called 'won'. Did you mean 'one'\?.*maximum"
    ):
        numbers(monkeypatch).get("won")


def test_what_breaks_is_one_warning_and_the_rest_works(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    found = numbers(
        monkeypatch, gone="no_such_module:x", wrong="sys:path", one="errno:EPERM", fine="errno:EIO"
    )
    with caplog.at_level(logging.WARNING):
        assert [name for name, _ in found.items()] == ["one", "maximum", "fine"]
        assert [name for name, _ in found.items()] == ["one", "maximum", "fine"]
    said = [record.getMessage() for record in caplog.records]
    assert len(said) == 3, "each fault once"
    assert any("its name is taken" in line for line in said)
    assert any("ModuleNotFoundError" in line for line in said)
    assert found["one"] == 1 and found["fine"] == 5
    for name, why in (("gone", "does not load"), ("wrong", "is a list, no number")):
        with pytest.raises(InputError, match=why):
            found.get(name)


def test_names_that_are_taken_and_things_of_another_kind_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = numbers(monkeypatch, soft="errno:EPERM")
    for name in ("one", "soft"):
        with pytest.raises(InputError, match="two numbers are called"):
            found.register(name, 3)
    with pytest.raises(InputError, match="is a str, no number"):
        found.register("three", "3")  # type: ignore[arg-type]
