"""An edited task is another task, and the same task is the same everywhere."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from robomore.tasks import TASKS, Task, get_task
from robomore.tasks.fingerprint import fingerprint, task_key
from robomore.tasks.own_source import own_source

ROBOT = '''"""A robot."""
import math
from functools import lru_cache
from robomore.tasks import Capsule, Parameter, Rule, Task

LIMIT = 0.4
WIDTHS = {"z": 1.0}


class Shell(Capsule):
    @property
    def volume(self):
        return thickness(self.radius) * self.length


def thickness(radius):
    return 2 * radius


@lru_cache
def limit(radius):
    return LIMIT + radius


def rarely(values):
    return "a case that no probe meets" if values["radius"] == 0.123456 else None


def too_long(values):
    return rarely(values) or ("too long" if values["length"] > 0.9 else None)


def scaled(factor):
    return lambda values: {"range": (0.0, factor * limit(values["radius"]))}


TASK = Task(
    id="tube", title="Tube", description="A tube.", fitness="distance", template="<mujoco/>",
    parameters=(
        Parameter("radius", 0.1, 0.5, 0.2, "radius"), Parameter("length", 0.1, 1.0, 0.5, "length"),
    ),
    shapes=lambda values: (Shell(values["radius"], values["length"]),), reward="def _get_rew(): 0",
    environment="tube_environment:Tube", options=scaled(2.0), constants={"gear": 1.0},
    rules=(Rule("not too long", too_long),),
)
'''

EDITS = {
    "a template": ('template="<mujoco/>"', 'template="<mujoco />"', "template"),
    "a bound": ("0.1, 0.5, 0.2", "0.1, 0.6, 0.2", "parameters"),
    "a reference": ("0.1, 0.5, 0.2", "0.1, 0.5, 0.21", "parameters options shapes"),
    "a meaning": ('0.2, "radius"', '0.2, "the radius"', "parameters"),
    "a constant": ('{"gear": 1.0}', '{"gear": 2.0}', "constants"),
    "a reward": ("_get_rew(): 0", "_get_rew(): 1", "reward"),
    "the fitness": ('fitness="distance"', 'fitness="height"', "fitness"),
    "the description": ('"A tube."', '"A long tube."', "description"),
    "a value in a closure": ("scaled(2.0)", "scaled(3.0)", "options"),
    "a text in a closure": ('"range"', '"healthy_range"', "options"),
    "a helper of the options": ("LIMIT + radius", "LIMIT + 2 * radius", "options"),
    "a constant of the module": ("LIMIT = 0.4", "LIMIT = 0.5", "options"),
    "a rule": ("> 0.9", "> 0.8", "rules"),
    "a rule's words": ('"not too long"', '"no longer"', "rules"),
    "a case that no probe meets": ("0.123456", "0.123457", ""),
    "a shape": ('values["length"]),)', '2 * values["length"]),)', "shapes"),
    "a class of a shape": ("* self.length", "+ self.length", "shapes"),
}
"""What is edited, and the part that changes besides the module's text (`code`)."""


def load(folder: Path, text: str) -> ModuleType:
    folder.mkdir()
    file = folder / "tube.py"
    file.write_text(text)
    spec = importlib.util.spec_from_file_location("tube", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Where the module is looked for is the folder that was loaded last.
    sys.modules.pop("tube", None)
    sys.path[:] = [str(folder), *(entry for entry in sys.path if "pytest-" not in entry)]
    importlib.invalidate_caches()
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def tube(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Task:
    monkeypatch.setitem(sys.modules, "tube", ModuleType("tube"))
    task = load(tmp_path / "tube", ROBOT).TASK
    fingerprint(task)
    assert isinstance(task, Task)
    return task


def changed(one: Task, other: Task) -> set[str]:
    first, second = fingerprint(one), fingerprint(other)
    assert first.keys() == second.keys()
    return {name for name in first if first[name] != second[name]}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_changes_the_part_that_it_is_in(edit: str, tube: Task, tmp_path: Path) -> None:
    before, after, parts = EDITS[edit]
    assert ROBOT.count(before) == 1
    edited = load(tmp_path / "edited", ROBOT.replace(before, after)).TASK
    assert changed(tube, edited) == {"code", *parts.split()}


def test_the_same_text_elsewhere_is_the_same_task(tube: Task, tmp_path: Path) -> None:
    assert task_key(load(tmp_path / "elsewhere", ROBOT).TASK) == task_key(tube)


@pytest.mark.parametrize(
    ("fields", "part"),
    [
        ({"terrain": get_task("ant-desert").terrain}, "terrain"),
        ({"episode_steps": 10}, "episode"),
        ({"version": 99}, "version"),
        ({"environment": "robomore.envs.robots.swimmer:SwimmerEnvironment"}, "environment"),
        ({"radii": ("torso_radius",)}, "parameters"),
    ],
)
def test_other_fields_are_parts_of_their_own(fields: dict[str, object], part: str) -> None:
    ant = get_task("ant")
    assert changed(ant, replace(ant, **fields)) == {part}  # type: ignore[arg-type]


def test_functions_without_a_text_are_known_by_their_results(tube: Task) -> None:
    space: dict[str, object] = {}
    exec("def one(v): return {'a': 1.0}\ndef two(v): return {'a': 2.0}", space)
    one, two = (replace(tube, options=space[name]) for name in ("one", "two"))  # type: ignore[arg-type]
    assert changed(one, two) == {"options"}
    assert changed(one, replace(tube, options=space["one"])) == set()  # type: ignore[arg-type]


def test_the_environment_counts_with_its_author_s_other_modules(
    tube: Task, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "package"
    package.mkdir()
    texts = {
        "__init__": "raise ImportError('nothing is imported for a fingerprint')\n",
        "public": "from package.bases import Chain\n",
        "bases": "from gymnasium import Env\n\nclass Chain(Env):\n    links = 3\n",
        "robot": "from . import public\n\nclass Base(public.Chain): ...\nclass Robot(Base): ...\n",
        "unused": "A = 1\n",
    }
    for name, text in texts.items():
        (package / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    names = ["package.bases", "package.public", "package.robot"]
    assert [name for name in own_source("package.robot") if "." in name] == names
    task = replace(tube, environment="package.robot:Robot")
    before = fingerprint(task)
    for name in ("bases", "public", "robot"):
        (package / f"{name}.py").write_text(texts[name] + "# edited\n")
        after = fingerprint(replace(task))
        assert {part for part in before if before[part] != after[part]} == {"environment"}
        before = after


def test_a_task_with_faults_has_a_fingerprint_all_the_same(tube: Task) -> None:
    def broken(values: object) -> dict[str, object]:
        raise ZeroDivisionError

    for environment in ("no.such.module:Robot", "nonsense", "", "sys:Robot"):
        faulty = replace(tube, options=broken, environment=environment)
        assert "options" in changed(tube, faulty)
        assert task_key(faulty) == task_key(replace(faulty))


def test_all_tasks_differ_and_are_the_same_in_a_fresh_process_without_a_simulator() -> None:
    code = (
        "import sys\nfrom robomore.tasks import TASKS, get_task\n"
        "from robomore.tasks.fingerprint import task_key\n"
        "print(*(task_key(get_task(id)) for id in TASKS.names()))\n"
        "assert not {'gymnasium', 'mujoco', 'numpy'} & set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    keys = [task_key(get_task(id)) for id in TASKS.names()]
    assert done.stdout.split() == keys
    assert len(set(keys)) == len(keys) == 9
    assert all(len(digits) == 16 for digits in fingerprint(get_task("ant")).values())
