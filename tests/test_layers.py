"""The house rules that a machine can see: who may import whom, and how files look."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "robomore"
MODULES = sorted(SOURCE.rglob("*.py"))

LAYERS = (
    {"errors", "post_import", "processes", "release", "text", "transport"},
    {"plain_files", "suggestions", "types"},
    {"identity", "plan", "registry", "settings", "statistics"},
    {"events", "options"},
    {"tasks"},
    {"envs", "llm", "sandbox"},
    {"importer", "rewards", "rendering"},
    {"store"},
    {"designers", "executors", "training"},
    {"evaluation"},
    {"search"},
    {"monitor", "runs", "trackers"},
    {"audit", "report", "visualize"},
    {"export"},
    {"experiment"},
    {"studies"},
    {"serve", "testing"},
    {"cli"},
)
"""From the ground up. A module imports its own package and what stands below it, nothing else."""

RANK = {name: rank for rank, layer in enumerate(LAYERS) for name in layer}

APART = {
    "llm": {"sandbox", "settings", "tasks"},
    "executors": {"llm", "sandbox", "store", "tasks"},
    "rendering": {"llm", "sandbox"},
    "search": {"envs", "evaluation", "executors", "llm", "sandbox", "store", "training"},
    "runs": {"evaluation", "executors", "sandbox", "search"},
    "audit": {"executors", "llm", "report", "sandbox", "search", "visualize"},
    "report": {"evaluation", "executors", "sandbox", "search", "training"},
    "visualize": {"evaluation", "executors", "sandbox", "search", "training"},
    "export": {"evaluation", "executors", "sandbox", "search"},
    "trackers": {"evaluation", "executors", "sandbox", "search", "store", "training"},
    "monitor": {"evaluation", "executors", "sandbox", "search", "store", "training"},
}
"""What a package does without although it stands below: an LLM knows no tasks, an executor no
robots, a search no files and no physics, and a report needs only a run's folder."""

UPWARDS = {
    ("runs/run.py", "report"),
    ("tasks/registry.py", "importer"),
    *(
        (f"tasks/{name}.py", "envs")
        for name in ("ant", "half_cheetah", "hopper", "swimmer", "walker")
    ),
}
"""Against the order: whoever holds a run asks it for its report, a path in the place of a task's id
is read by the importer, and a task names its environment,
as text that is imported only where something is simulated."""

NAMED = {("tasks", "envs")}
"""A task names the class of its environment as text; only `envs` ever loads it."""

HEAVY = ("gymnasium", "jax", "jaxlib", "matplotlib", "mujoco", "plotly", "ray", "scipy", "torch")
MODEL_LIBRARIES = ("anthropic", "google.genai", "openai", "pydantic_ai")

VAGUE = {"common.py", "helper.py", "helpers.py", "misc.py", "util.py", "utils.py"}

LONGEST = 375
"""Lines in a file; hardly any needs as many."""

_REFERENCE = re.compile(r"robomore((?:\.\w+)+)(?::\w+)?")
"""A module named in text (`"robomore.training.crossq:CrossQ"`) is imported all the same."""


def top_name(dotted: str) -> str | None:
    """Return `store` for `robomore.store.ledger`, `None` for `robomore` itself and for others."""
    first, _, rest = dotted.partition(".")
    return rest.partition(".")[0] or None if first == "robomore" else None


def imported(module: Path) -> Iterator[tuple[int, str]]:
    """Yield (line, top name) of what a module imports of RoboMoRe, anywhere in it."""
    for node in ast.walk(ast.parse(module.read_text())):
        match node:
            case ast.Import(names=names):
                found = [alias.name for alias in names]
            case ast.ImportFrom(module="robomore", names=names):
                found = [f"robomore.{alias.name}" for alias in names if alias.name in RANK]
            case ast.ImportFrom(module=str(dotted), level=0):
                found = [dotted]
            case ast.ImportFrom():
                raise AssertionError(f"{module.name}:{node.lineno}: import by full name")
            case ast.Constant(value=str(text)) if reference := _REFERENCE.fullmatch(text):
                # Groups of entry points look the same, but name no module.
                named = (importer(module), top_name(text)) in NAMED
                found = ["robomore" + reference[1]] if top_name(text) in RANK and not named else []
            case _:
                continue
        yield from (
            (node.lineno, name) for dotted in found if (name := top_name(dotted)) is not None
        )


def place(module: Path) -> str:
    return module.relative_to(SOURCE).as_posix()


def importer(module: Path) -> str:
    """Return the package or top module that `module` belongs to."""
    return place(module).partition("/")[0].removesuffix(".py")


def test_every_module_stands_in_a_layer() -> None:
    unknown = {importer(module) for module in MODULES} - set(RANK) - {"__init__", "__main__"}
    assert not unknown, f"give {unknown} a place in LAYERS"


def test_a_module_imports_only_what_stands_below_it() -> None:
    faults = []
    for module in MODULES:
        own = importer(module)
        if own in ("__init__", "__main__"):
            continue  # the front doors: `import robomore` is held to what it loads, below
        faults += [
            f"{place(module)}:{line} imports {name}"
            for line, name in imported(module)
            if name != own
            and (place(module), name) not in UPWARDS
            and (RANK.get(name, len(RANK)) >= RANK[own] or name in APART.get(own, ()))
        ]
    assert not faults


def loaded_by(statement: str) -> set[str]:
    """Return the modules that a fresh interpreter has loaded after `statement`."""
    code = f"{statement}\nimport sys\nprint(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.split())


def all_of(package: str) -> str:
    names = [
        "robomore." + place(module).removesuffix(".py").replace("/", ".").removesuffix(".__init__")
        for module in MODULES
        if importer(module) == package
    ]
    assert names
    return "import " + ", ".join(names)


@pytest.mark.parametrize(
    ("statement", "unwanted"),
    [
        ("import robomore", (*HEAVY, *MODEL_LIBRARIES, "numpy")),
        (all_of("search"), (*HEAVY, *MODEL_LIBRARIES, "sqlite3")),
        (all_of("executors"), (*HEAVY, *MODEL_LIBRARIES)),
        ("import robomore.llm", (*HEAVY, *MODEL_LIBRARIES)),
        (all_of("report"), ("jax", "jaxlib", "torch")),
        (all_of("runs"), ("jax", "jaxlib", "mujoco", "torch")),
        (all_of("monitor"), HEAVY),
        (all_of("trackers"), (*HEAVY, "tensorboardX", "wandb")),
        (all_of("tasks"), (*HEAVY, *MODEL_LIBRARIES)),
        ("import robomore.cli", (*HEAVY, *MODEL_LIBRARIES)),
    ],
    ids=[
        "robomore",
        "search",
        "executors",
        "llm",
        "report",
        "runs",
        "monitor",
        "trackers",
        "tasks",
        "cli",
    ],
)
def test_what_is_loaded(statement: str, unwanted: tuple[str, ...]) -> None:
    too_much = loaded_by(statement) & set(unwanted)
    assert not too_much


def test_a_file_holds_one_concept_and_says_so() -> None:
    faults = []
    for module in MODULES:
        text = module.read_text()
        faults += [f"{place(module)}: a name that says nothing"] * (module.name in VAGUE)
        faults += [f"{place(module)}: {LONGEST} lines or more"] * (text.count("\n") >= LONGEST)
        faults += [f"{place(module)}: no docstring"] * (not ast.get_docstring(ast.parse(text)))
    assert not faults


def test_the_library_logs_and_does_not_print() -> None:
    prints = [
        f"{place(module)}:{node.lineno}"
        for module in MODULES
        if importer(module) != "cli"
        for node in ast.walk(ast.parse(module.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "print"
    ]
    assert not prints
