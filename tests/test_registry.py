"""One registry for all kinds of plug-in: found, refused, and never in the way of the others."""

from __future__ import annotations

import importlib.metadata
import logging
from importlib.metadata import EntryPoint
from pathlib import Path

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


def test_a_package_that_announces_nonsense_hides_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    for name, text in (("fine", "[numbers]\nfine = errno:EIO\n"), ("bad", "[numbers]\nbad\n")):
        about = tmp_path / f"{name}-0.1.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1\n")
        (about / "entry_points.txt").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    found = Registry("number", "numbers", {"one": 1}, fault)
    assert dict(found.items()) == {"one": 1, "fine": 5}
    assert "the package bad cannot be read" in caplog.text


def test_a_plugin_that_ends_the_process_is_a_warning_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "own_exits.py").write_text("raise SystemExit(3)")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert dict(numbers(monkeypatch, bad="own_exits:X", fine="errno:EIO").items())["fine"] == 5
    assert "SystemExit" in caplog.text
