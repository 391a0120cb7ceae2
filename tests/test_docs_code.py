"""The Python of the documents does what they say: every block and the notebook run as they are.

They read runs that are real but for their numbers and policies, which nothing was trained for.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Generator, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import msgspec
import numpy as np
import pytest

import robomore
from robomore.envs.registration import make_environment
from robomore.evaluation.request import Answer
from robomore.executors import EXECUTORS, Done, Outcome
from robomore.report import page
from robomore.settings import preset, with_method
from robomore.training.policy import MLPPolicy
from untrained import Untrained

ROOT = Path(__file__).parents[1]
TASK = "half-cheetah"
"""Of the run that the documents make, and of the one that stands for `make demo`'s."""

_PYTHON = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@cache
def blocks(document: Path) -> tuple[str, ...]:
    return tuple(_PYTHON.findall(document.read_text()))


DOCUMENTS = [
    path
    for pattern in ("*.md", "docs/**/*.md", "examples/**/*.md")
    for path in sorted(ROOT.glob(pattern))
    if blocks(path)
]


def notebook_cells() -> list[str]:
    notebook = json.loads((ROOT / "examples" / "notebook.ipynb").read_text())
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]


class WithPolicies(Untrained):
    """Gives every evaluation a policy that nobody trained."""

    def map(self, *given: Any, **more: Any) -> Generator[tuple[int, Outcome]]:
        environment = make_environment(TASK)
        spaces = (environment.observation_space, environment.action_space)
        sizes = [size for space in spaces for size in space.shape or ()]
        random = np.random.default_rng(0)
        weight = random.normal(0, 0.1, sizes).astype(np.float32)
        policy = MLPPolicy((weight,), (np.zeros(sizes[1], np.float32),)).to_bytes()
        for index, outcome in super().map(*given, **more):
            assert isinstance(outcome, Done)
            answer = msgspec.json.decode(outcome.reply, type=Answer)
            yield index, Done(msgspec.json.encode(Answer(answer.evaluation, policy)))


if "with-policies" not in EXECUTORS:
    EXECUTORS.register("with-policies", WithPolicies)


@pytest.fixture(scope="module", autouse=True)
def still() -> Generator[None]:
    """Nothing moves in the reports of these runs, which would take seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "recorded", lambda run, key, name: None)
        yield


@pytest.fixture(scope="module")
def home(still: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project's folder with the runs that the documents speak of."""
    home = tmp_path_factory.mktemp("home")
    (home / "examples").mkdir()
    run = robomore.run(TASK, "quick", executor="with-policies", out=home / "runs" / "demo")
    shutil.copytree(home / "runs" / "demo", home / "runs" / "cheetah")
    robomore.run(
        TASK,
        with_method(preset("quick"), "random"),
        executor="with-policies",
        out=home / "runs" / "random",
        budget_steps=run.search_steps,
    )
    return home


@pytest.fixture(autouse=True)
def figures() -> Generator[None]:
    """Figures are drawn without a screen, and closed."""
    plt.switch_backend("agg")
    yield
    plt.close("all")


def execute(pieces: Sequence[str], name: str) -> None:
    """Run pieces of code one after the other, as a reader would."""
    known: dict[str, Any] = {"__name__": "__main__"}
    for number, piece in enumerate(pieces, start=1):
        if "to_dataframe" in piece and find_spec("pandas") is None:
            continue  # They say that they need it.
        exec(compile(piece, f"{name}, block {number}", "exec"), known)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_block_of_a_document_runs(
    document: Path, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(home)
    execute(blocks(document), document.name)


def test_the_notebook_runs(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(home / "examples")
    execute(notebook_cells(), "notebook.ipynb")


def test_the_notebook_is_valid_and_holds_no_output() -> None:
    notebook = json.loads((ROOT / "examples" / "notebook.ipynb").read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in notebook["cells"]]
    assert len(set(ids)) == len(ids) and all(re.fullmatch(r"[\w-]{1,64}", id) for id in ids)
    for cell in notebook["cells"]:
        required = {"cell_type", "id", "metadata", "source"}
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [] and cell["execution_count"] is None
            required |= {"outputs", "execution_count"}
        assert set(cell) == required and cell["cell_type"] in ("code", "markdown")


TYPED = """
from pathlib import Path

import robomore
from robomore.settings import RunSettings, preset, with_method

settings: RunSettings = with_method(preset("quick"), "random", {"samples": 4})
run = robomore.run("swimmer", settings, seed=1, out=Path("run"), budget_steps=10**6)
reveal_type(run)
reveal_type(robomore.run)
reveal_type(robomore.load_run("run").champion)
reveal_type(robomore.compare([run, "other"]))
reveal_type(robomore.get_task("ant"))
reveal_type(robomore.evaluate("swimmer", {"length": 0.1}).status)
reveal_type(run.load_policy())
"""
"""What a user with a type checker writes."""

STRICT = """
[mypy]
strict = true
follow_imports = skip
[mypy-robomore.*]
follow_imports = silent
"""
"""Strict on the user's code; other packages are left out, since they take a minute to read."""


def test_a_users_code_is_typed(tmp_path: Path) -> None:
    (tmp_path / "mypy.ini").write_text(STRICT)
    (tmp_path / "right.py").write_text(TYPED)
    (tmp_path / "wrong.py").write_text('import robomore\n\nrobomore.run("swimmer", sed=1)\n')
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-incremental", "right.py", "wrong.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    run, function, *others = re.findall(r'Revealed type is "(.*?)"$', checked.stdout, re.MULTILINE)
    assert run == "robomore.runs.run.Run"
    assert function.endswith("-> robomore.runs.run.Run") and "budget_steps: int | None" in function
    assert others == [
        "robomore.runs.trained.TrainedDesign | None",
        "robomore.runs.comparison.Comparison",
        "robomore.tasks.task.Task",
        "robomore.types.Status",
        "robomore.training.policy.MLPPolicy",
    ]
    errors = [line for line in checked.stdout.splitlines() if ": error:" in line]
    assert len(errors) == 1 and errors[0].startswith("wrong.py") and '"sed"' in errors[0]
