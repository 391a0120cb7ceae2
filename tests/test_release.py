"""Between two releases, the state of the code is part of what a result is known by."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from robomore import release
from robomore.release import development_source
from robomore.store.manifest import package_versions


@pytest.fixture(autouse=True)
def looked_at_anew() -> Iterator[None]:
    development_source.cache_clear()
    yield
    development_source.cache_clear()


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of two rooms in the place of ours, of a version that was not released."""
    for room in ("search", "report"):
        (tmp_path / room).mkdir()
        (tmp_path / room / "one.py").write_text("A = 1\n")
    monkeypatch.setattr(release, "__file__", str(tmp_path / "release.py"))
    monkeypatch.setattr(release, "VERSION", "1.2.0.dev0")
    return tmp_path


def source() -> str:
    development_source.cache_clear()
    return package_versions()["robomore source"]


def test_an_edit_of_what_decides_numbers_is_another_source(package: Path) -> None:
    before = source()
    assert source() == before
    (package / "search" / "one.py").write_text("A = 2\n")
    edited = source()
    (package / "search" / "one.py").rename(package / "search" / "two.py")
    assert len({before, edited, source()}) == 3


def test_an_edit_of_a_page_is_not(package: Path) -> None:
    before = source()
    (package / "report" / "one.py").write_text("A = 2\n")
    assert source() == before


def test_a_released_version_is_known_by_its_number(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(release, "VERSION", "1.2.0")
    assert development_source() is None
    assert "robomore source" not in package_versions()


def test_all_that_decides_numbers_is_there() -> None:
    ours = Path(release.__file__).parent
    assert all((ours / part / "__init__.py").is_file() for part in release._DECIDE_NUMBERS)
