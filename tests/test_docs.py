"""What the documents say exists: links, commands, verbs; and what they must never say."""

from __future__ import annotations

import json
import re
import shlex
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from functools import cache
from pathlib import Path
from pkgutil import resolve_name

import msgspec
import pytest
from cyclopts import CycloptsError

from fake_run import FakeRun, finished_run
from robomore import compare, load_run
from robomore.cli.app import COMMANDS, application
from robomore.designers import DESIGNERS
from robomore.executors import EXECUTORS
from robomore.search import METHODS
from robomore.search.final import stage as final_stage
from robomore.search.measure import survivor_count
from robomore.search.robomore.settings import RoboMoReSettings
from robomore.settings import PRESETS, from_options, preset
from robomore.store import RunFolder
from robomore.store.schema import TABLES
from robomore.tasks import TASKS, get_task
from robomore.training.settings import TRAINERS
from robomore.types import Status

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted(
    path for pattern in ("*.md", "docs/**/*.md", "examples/**/*.md") for path in ROOT.glob(pattern)
)

_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)[^)]*\)|<img[^>]*\ssrc=\"([^\"]+)\"")
_HEADING = re.compile(r"^#+ +(.+?) *$", re.MULTILINE)

STAND_INS = {
    "TASK": "ant",
    "RUN": "runs/demo",
    "KEY": "1f",
    "DESIGN": "runs/demo/champion",
    "FILE.json": "body.json",
    "FILE.py": "reward.py",
    "DIR": "runs/other",
    "NAME": "name",
    "N": "1",
}
"""Words in capitals that stand for a user's own, and something that parses in their place."""

SHELL = ("", "bash", "console", "sh", "shell", "text")


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def prose(document: Path) -> str:
    """Return a document without its blocks of code."""
    return _FENCE.sub("", document.read_text())


@cache
def anchors(document: Path) -> set[str]:
    """Return what a document's headings are linked as."""
    found: set[str] = set()
    for heading in _HEADING.findall(prose(document)):
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
        found.add(re.sub(r"[^\w\- ]", "", text).replace(" ", "-"))
    return found


def code(document: Path) -> Iterator[str]:
    """Yield the lines of a document's shell blocks, and its inline code."""
    for language, block in _FENCE.findall(document.read_text()):
        if language in SHELL:
            yield from block.replace("\\\n", " ").splitlines()
    yield from _INLINE.findall(prose(document))


def commands(program: str) -> list[tuple[str, str]]:
    """Return (document, arguments) of each use of `program` in the documents."""
    found: list[tuple[str, str]] = []
    for document in DOCUMENTS:
        for line in code(document):
            start = re.match(rf"(?:\$ )?(?:\S*/)?{program} (.+)", line.strip())
            if start:
                found.append((named(document), start[1]))
    return list(dict.fromkeys(found))


@pytest.mark.parametrize("document", DOCUMENTS, ids=named)
def test_links_lead_somewhere(document: Path) -> None:
    broken = []
    for pair in _LINK.findall(prose(document)):
        target = pair[0] or pair[1]
        if "://" in target or target.startswith("mailto:"):
            continue
        path, _, anchor = target.partition("#")
        file = (document.parent / path).resolve() if path else document
        if not file.exists() or (anchor and anchor not in anchors(file)):
            broken.append(target)
    assert not broken


def test_the_picture_moves_and_is_small() -> None:
    from PIL import Image

    path = ROOT / "docs" / "assets" / "champion.webp"
    assert path.stat().st_size < 3 * 2**20
    with Image.open(path) as picture:
        assert getattr(picture, "n_frames", 1) > 100
    # The verb runs the very command that the page names, and what it writes is nobody's change.
    command = "robomore play runs/demo --beside --seconds 10 --out runs/demo/champion.webp"
    assert f"$(BIN)/{command}\n" in (ROOT / "Makefile").read_text()
    assert f"\n{command}\n" in (ROOT / "README.md").read_text()
    assert "/runs/" in (ROOT / ".gitignore").read_text().splitlines()
    renewed = "cp runs/demo/champion.webp docs/assets/champion.webp"
    assert renewed in (ROOT / "CONTRIBUTING.md").read_text()


def test_the_documents_show_commands() -> None:
    shown = {arguments.split()[0] for _, arguments in commands("robomore")}
    assert shown >= set(COMMANDS), "a command that no document shows"


@pytest.mark.parametrize(("document", "arguments"), commands("robomore"))
def test_commands_parse(document: str, arguments: str) -> None:
    words = [STAND_INS.get(word, word) for word in shlex.split(arguments, comments=True)]
    for end in ("|", ">", "&&", ";"):
        if end in words:
            words = words[: words.index(end)]
    words = [word for word in words if word != "--debug"]  # taken out before parsing
    if len(words) == 1 and words[0] in COMMANDS:
        return  # a sentence about the command
    try:
        _, bound, _ = application().parse_args(words, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        pytest.fail(f"{document}: robomore {arguments}: {error}")
    task = bound.arguments.get("task")
    if task is not None and task not in third_party_tasks() and not task.endswith(".toml"):
        get_task(task)


def third_party_tasks() -> set[str]:
    """Return the ids of tasks that the examples add once they are installed."""
    text = "".join(path.read_text() for path in ROOT.glob("examples/**/*.py"))
    return set(re.findall(r'^\s+id="([\w-]+)"', text, re.MULTILINE)) - set(TASKS)


@pytest.mark.parametrize("document", DOCUMENTS, ids=named)
def test_names_in_documents_exist(document: Path) -> None:
    # Groups of entry points look like modules, and some are.
    groups = {one.group for one in (TASKS, METHODS, DESIGNERS, TRAINERS, EXECUTORS)}
    for name in set(re.findall(r"`(robomore(?:\.[A-Za-z_]+)+)", prose(document))) - groups:
        resolve_name(name)


def test_verbs_of_make_exist() -> None:
    verbs = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    used = {arguments.split()[0] for _, arguments in commands("make")}
    assert used and used <= verbs


def runs_page() -> str:
    return (ROOT / "docs" / "runs.md").read_text()


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_told_as_they_are(name: str, tmp_path: Path) -> None:
    settings = preset(name)
    sizes = from_options(RoboMoReSettings, settings.method.options, name)
    candidate, last = settings.candidate, settings.final

    def several(count: int, word: str) -> str:
        return f"{count:,} {word}{'s' if count > 1 else ''}"

    cells = (
        f"`{name}`",
        f"{sizes.morphologies} by {sizes.rewards}",
        sizes.reference_reward,
        str(survivor_count(sizes.survivors, sizes.morphologies * sizes.rewards)),
        str(sizes.max_cycles),
        f"{several(candidate.steps, 'step')}, {several(candidate.episodes, 'episode')}",
        f"{several(last.finalists, 'design')}, {several(last.seeds, 'seed')}, "
        f"{several(last.steps, 'step')}, {several(last.episodes, 'episode')}",
    )
    assert f"| {' | '.join(cells)} |" in runs_page()

    plan = FakeRun(tmp_path, settings=settings).manifest.plan
    final = final_stage(last)
    search = [stage for stage in plan.stages if stage.role != "final"]
    most = (
        sum(stage.evaluations for stage in search),
        final.evaluations,
        sum(stage.steps for stage in search),
        final.steps,
    )
    assert f"| `{name}` | {' | '.join(f'{number:,}' for number in most)} |" in runs_page()


def test_every_file_table_and_status_of_a_run_is_told() -> None:
    folder = RunFolder(Path("run"))
    files = [file for name, file in vars(folder).items() if not name.startswith("_")]
    names = [file.name for file in files]
    assert [name for name in names if name != "run" and f"`{name}" not in runs_page()] == []
    assert [table for table in TABLES if f"| `{table} (" not in runs_page()] == []
    assert [status for status in Status if f"| `{status}` |" not in runs_page()] == []


def test_every_column_is_told(tmp_path: Path) -> None:
    run = load_run(finished_run(tmp_path).path)
    page = runs_page()
    told = page[page.index("### The table") : page.index("In the CSV file")]
    missing = set(run.rows()[0]) - set(re.findall(r"`(\w+)`", told)) - set(run.task.names)
    assert not missing
    methods = (ROOT / "docs" / "methods.md").read_text()
    told = methods[methods.index("`compare` has one row") : methods.index("## A method of your")]
    assert not set(compare([run]).rows()[0]) - set(re.findall(r"`(\w+)`", told))


@pytest.mark.parametrize("name", [name for name in METHODS if name != "eureka-morphology"])
def test_options_of_methods_are_told_as_they_are(name: str) -> None:
    page = (ROOT / "docs" / "methods.md").read_text()
    section = page[page.index(f"## `{name}`") :].split("\n## ")[0]
    told = dict(re.findall(r"^\| `(\w+)` \| (.+?) \|", section, re.MULTILINE))
    options = METHODS.get(name).Settings
    expected = msgspec.to_builtins(options())
    rungs = expected.pop("rungs", None)
    assert rungs is None or (told.pop("rungs") == "see below" and json.dumps(rungs) in section)
    assert told == {option: f"`{json.dumps(value)}`" for option, value in expected.items()}


def test_queries_run_on_a_ledger(tmp_path: Path) -> None:
    finished_run(tmp_path)
    queries = re.findall(r'^sqlite3 \S+ "(.*?)"$', runs_page(), re.MULTILINE | re.DOTALL)
    with closing(sqlite3.connect(tmp_path / "ledger.sqlite")) as ledger:
        for query in queries:
            assert ledger.execute(query).fetchall(), query
    assert len(queries) == 2


def texts() -> Iterator[tuple[str, str]]:
    """Yield (name, text) of the project's files, wherever the project lies."""
    folders = (".ci", "benchmarks", "docs", "examples", "lock", "src", "tests")
    paths = [path for path in ROOT.iterdir() if path.is_file()]
    paths += [path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file()]
    for path in paths:
        content = path.read_bytes()
        if b"\0" not in content and not {"__pycache__", "node_modules"} & set(path.parts):
            yield named(path), content.decode(errors="replace")


def test_no_file_names_a_place_that_only_one_machine_has() -> None:
    # Put together here, so that this file does not name them either.
    hosts = ("pypi" + ".org", "python" + "hosted.org", "ana" + "conda.org", "npm" + "js.")
    places = [re.escape(host) for host in hosts]
    places += [
        rf"(?<!\w){re.escape(str(place))}\b"
        for place in (ROOT, Path.home())
        if place.parent != place
    ]
    pattern = re.compile("|".join(places))
    found = {
        name: hit[0]
        for name, text in texts()
        if name != named(Path(__file__)) and (hit := pattern.search(text))
    }
    assert not found
