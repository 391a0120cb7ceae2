"""No text that somebody else wrote steers a terminal, whichever command shows it."""

from __future__ import annotations

import ast
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

import robomore.cli
from cli.commands import Command, Said
from fake_run import NASTY, FakeRun
from robomore.cli.clean_console import CleanConsole
from robomore.cli.live import PlainLines
from robomore.events import Proposed
from robomore.types import Design, Place, Reward, Slot, Status

HOSTILE = "a\x1b]0;title\x07b\x1b[2Jc\x9bm\u202ed\u2066e\rf\x08g\x7f\u2028[/red]:smile:[bold]"
BAD = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole run in which every text is hostile."""
    made = FakeRun(tmp_path_factory.mktemp("runs") / "\x1b[31mrun[/]")
    morphology = replace(made.morphology(0.5), idea=HOSTILE)
    source = f"def _get_rew(self, x_velocity, action):\n    return 0.0, {{}}  # {HOSTILE}\n"
    design = Design(morphology, Reward(source, HOSTILE))
    place = Place(stage="coarse", index=(0, 0))
    made.add(design, place, None, Status.REWARD_FAILED, HOSTILE)
    made.final(made.add(design, replace(place, index=(1, 0)), 10.0))
    manifest = replace(made.manifest, provenance=HOSTILE, preset=HOSTILE, designer=HOSTILE)
    manifest.save(made.folder.manifest)
    return made.path


def clean(said: Said) -> bool:
    return not BAD.search(said.out + said.err)


@pytest.mark.parametrize(
    "command",
    [
        "show RUN",
        "show RUN --json",
        "compare RUN",
        "compare RUN --json",
        "compare RUN --csv -",
        "export RUN --csv -",
        "prompt swimmer improve-reward --from RUN",
        "prompt swimmer improve-morphology --from RUN --json",
        "report RUN",
        "play RUN",
        "show RUN --evaluation HOSTILE",
        "show HOSTILE",
        "HOSTILE",
        "run HOSTILE",
        "run ant --trainer HOSTILE",
        "check-reward ant HOSTILE",
        "inspect ant --parameters HOSTILE",
        "show HOSTILE --debug",
    ],
)
def test_a_terminal_is_not_steered(command: str, run: Path, robomore_: Command) -> None:
    words = {"RUN": str(run), "HOSTILE": HOSTILE}
    said = robomore_(*(words.get(word, word) for word in command.split()))
    assert clean(said), repr(said)
    assert said.out or said.err
    if "RUN" in command and "HOSTILE" not in command and not command.startswith("play"):
        assert said.status == 0, said.err


def test_the_page_holds_no_such_character_either(run: Path, robomore_: Command) -> None:
    assert robomore_("report", run).status == 0
    page = (run / "report.html").read_text(encoding="utf-8")
    assert not BAD.search(page) and NASTY not in page


def test_json_loses_no_letter(run: Path, robomore_: Command) -> None:
    told = robomore_("show", run, "--json").out
    assert HOSTILE in json.dumps(json.loads(told), ensure_ascii=False).replace(
        json.dumps(HOSTILE, ensure_ascii=False)[1:-1], HOSTILE
    )


def test_in_a_terminal_only_styles_are_escape_sequences() -> None:
    file = io.StringIO()
    screen = CleanConsole(file=file, force_terminal=True, width=80, markup=False, emoji=False)
    table = Table(HOSTILE, title=HOSTILE)
    table.add_row(HOSTILE, style="red")
    for shown in (HOSTILE, Text(HOSTILE, style="bold"), table, ProgressBar(3, 1, width=10)):
        screen.print(shown)
    written = file.getvalue()
    assert "\x1b[" in written
    assert not BAD.search(re.sub(r"\x1b\[[\d;]*m", "", written))


def test_a_running_search_tells_one_clean_line_each() -> None:
    stream = io.StringIO()
    PlainLines(stream)(Proposed(Slot("coarse", "reward", (0,)), "", f"{HOSTILE}\nmore"))
    assert stream.getvalue().count("\n") == 1 and not BAD.search(stream.getvalue())


def test_nothing_in_the_command_line_writes_past_the_one_place_that_cleans() -> None:
    for module in Path(robomore.cli.__file__).parent.glob("*.py"):
        if module.name in ("output.py", "live.py"):
            continue
        calls = [node for node in ast.walk(ast.parse(module.read_text())) if type(node) is ast.Call]
        written = [it for it in map(ast.unparse, (call.func for call in calls)) if "std" in it]
        assert [it for it in written if it.endswith(".write")] == [], module.name
