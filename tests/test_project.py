"""The project's own papers: versions agree, entry points load, the lock is a lock."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions, version
from itertools import chain
from pathlib import Path
from typing import Any

import pytest

import robomore

ROOT = Path(__file__).parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
LOCKS = ("base.txt", "dev.txt")

_PINNED = re.compile(r"^([a-z0-9-]+)==(\S+)(?: ; [^\\]+)? \\$", re.MULTILINE)


def locked(lock: str) -> dict[str, str]:
    return dict(_PINNED.findall((ROOT / "lock" / lock).read_text()))


def plain(requirement: str) -> str:
    """Return the name in `gymnasium[mujoco]>=1.1` as lock files spell it."""
    return re.split(r"[\[<>=!~; ]", requirement)[0].lower().replace("_", "-")


def test_one_version() -> None:
    stated = PROJECT["project"]["version"]
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited is not None
    assert {stated, robomore.__version__, version("robomore"), cited[1]} == {stated}


def test_the_changelog_tells_of_what_is_coming_and_of_what_is_out() -> None:
    headings = re.findall(r"^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert headings[0] == "Unreleased"
    assert len(headings) == len(set(headings))


@pytest.mark.parametrize(
    "target",
    [
        *PROJECT["project"]["scripts"].values(),
        *(
            target
            for group in PROJECT["project"].get("entry-points", {}).values()
            for target in group.values()
        ),
    ],
)
def test_entry_points_load(target: str) -> None:
    module, _, name = target.partition(":")
    assert callable(getattr(importlib.import_module(module), name))


@pytest.mark.parametrize("name", robomore.__all__)
def test_public_names_are_there(name: str) -> None:
    assert getattr(robomore, name) is not None


def test_a_misspelt_public_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="evalute"):
        robomore.evalute  # noqa: B018


def test_the_command_line_answers_as_a_script_and_as_a_module() -> None:
    script = Path(sys.executable).with_name("robomore")
    for command in ([script], [sys.executable, "-m", "robomore"]):
        done = subprocess.run([*command, "--version"], capture_output=True, text=True, timeout=60)
        assert done.stdout.strip() == robomore.__version__


@pytest.mark.parametrize("lock", LOCKS)
def test_a_lock_pins_every_requirement_with_hashes(lock: str) -> None:
    text = (ROOT / "lock" / lock).read_text()
    entries = re.findall(r"^\S.*?(?=^\S|\Z)", text, re.MULTILINE | re.DOTALL)
    unpinned = [e for e in entries if not (_PINNED.match(e) and "--hash=sha256:" in e)]
    assert entries and not unpinned

    groups = {"base.txt": "build", "dev.txt": "dev"}
    wanted = [*PROJECT["project"]["dependencies"], *group(groups[lock])]
    assert {plain(requirement) for requirement in wanted} <= locked(lock).keys()


@pytest.mark.parametrize("lock", LOCKS)
def test_a_lock_names_no_place(lock: str) -> None:
    text = (ROOT / "lock" / lock).read_text()
    assert not re.search(r"://|--(extra-)?index-url|--find-links|^-f ", text, re.MULTILINE)
    # Half a gigabyte that only the extra trainer needs.
    assert "torch" not in locked(lock)


def test_what_is_imported_is_declared() -> None:
    project = PROJECT["project"]
    wanted = [*project["dependencies"], *chain(*project.get("optional-dependencies", {}).values())]
    declared = {plain(requirement) for requirement in wanted}
    distributions = packages_distributions()
    missing = {
        name
        for module in (ROOT / "src").rglob("*.py")
        for name in imported(module)
        if name not in sys.stdlib_module_names
        and name != "robomore"
        # Who provides it, or, where an extra is not installed, the name itself.
        and not declared & {plain(found) for found in distributions.get(name, [name])}
    }
    assert not missing


def imported(module: Path) -> set[str]:
    """Return the top names of all that a module imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.partition(".")[0])
    return found


def test_development_uses_what_users_get() -> None:
    assert locked("base.txt").items() <= locked("dev.txt").items()


def group(name: str) -> list[str]:
    """Return the requirements of a dependency group, those that it includes too."""
    found: list[str] = []
    for entry in PROJECT["dependency-groups"][name]:
        found += group(entry["include-group"]) if isinstance(entry, dict) else [entry]
    return found


def test_the_example_task_is_a_sound_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    from robomore.envs.compile import body_facts

    folder = ROOT / "examples" / "eel"
    announced = tomllib.loads((folder / "pyproject.toml").read_text())["project"]["entry-points"]
    module, _, name = announced["robomore.tasks"]["eel"].partition(":")
    monkeypatch.syspath_prepend(folder)
    eel = getattr(importlib.import_module(module), name)

    facts = body_facts(eel, eel.reference)
    # Of MuJoCo's default density, so that volume and template check each other.
    assert facts["mass"] == pytest.approx(1000 * facts["volume"])
    assert eel.rules[0].violation({"head_radius": 0.1, "tail_radius": 0.2})


def test_who_lacks_a_package_is_told_the_extra_that_has_it() -> None:
    """An extra has the versions that fit, and all that is needed with them."""
    extras = PROJECT["project"]["optional-dependencies"]
    packages = {plain(one) for each in extras.values() for one in each}
    # Texts are broken over lines.
    said = re.compile(r"pip install (?:\s|['\"])*(robomore\[(\w+)\]|[\w-]+)")
    for path in sorted((ROOT / "src").rglob("*.py")):
        for found in said.finditer(path.read_text()):
            assert plain(found[1]) not in packages, f"{path.name}: name the extra, not {found[1]}"
            assert found[2] is None or found[2] in extras, f"{path.name}: {found[1]}"
