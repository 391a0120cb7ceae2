"""`robomore run`: the search, watched as it goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from robomore.cli.completion import TASK
from robomore.cli.inputs import read_start, seed_number
from robomore.cli.llm import ModelOptions, ReplayOptions, chosen, forecast
from robomore.cli.output import tell, write, write_json
from robomore.cli.run_options import Final, Machine, Search, Training, settings_of
from robomore.cli.whole import Whole

if TYPE_CHECKING:
    from robomore.designers import LanguageModel, Replay

_OUTPUT = Group("Output", sort_key=8)


def run(
    task: Annotated[str, TASK],
    /,
    *,
    seed: Whole = 0,
    search: Search | None = None,
    training: Training | None = None,
    final: Final | None = None,
    designer: Annotated[str | None, Parameter(group=Group("Designer", sort_key=4))] = None,
    hint: Annotated[str, Parameter(group=Group("Designer", sort_key=4))] = "",
    model: ModelOptions | None = None,
    replay: ReplayOptions | None = None,
    machine: Machine | None = None,
    tracker: Annotated[list[str] | None, Parameter(negative="", group=_OUTPUT)] = None,
    quiet: Annotated[bool, Parameter(negative="", group=_OUTPUT)] = False,
    as_json: Annotated[bool, Parameter("--json", negative="", group=_OUTPUT)] = False,
) -> int:
    """Search for the best morphology and reward for a task.

    The same command again finishes a run that was stopped. Exits with status 1 if a time limit was
    over before anything was trained.

    Parameters
    ----------
    task
        Id of a task (`robomore tasks` lists them), or the path of a task file (.toml).
    seed
        Seed of the run. The same seed gives the same result with any number of workers.
    designer
        Who proposes morphologies and rewards: `offline` (no language model; the default), `llm`
        (with `--model`) or `replay` (with `--from`). Some methods ask no designer.
    tracker
        Tell a tracker the numbers as they come: `tensorboard`, `wandb` or `trackio`. May be given
        several times.
    hint
        Your remark for a language model. While the run goes on, the file `hint.txt` in its folder
        holds more: what it says is added to the next requests.
    quiet
        Show nothing while the run goes on.
    as_json
        Print the outcome as JSON, as `robomore show --json` does.
    """
    from robomore.options import settings_name
    from robomore.search import make_method
    from robomore.tasks import get_task

    search, machine = search or Search(), machine or Machine()
    seed_number(seed)
    machine.check()
    wanted = get_task(task)
    settings = settings_of(search, training or Training(), final or Final())
    proposing: str | LanguageModel | Replay | None
    if not make_method(settings.method).needs_designer:
        # What is given all the same is refused when the run starts.
        proposing = designer or ("llm" if model else "replay" if replay else None)
    else:
        proposing = chosen(designer, model, replay)

    from robomore.cli.live import watched
    from robomore.designers import LanguageModel
    from robomore.experiment import run as start

    if isinstance(proposing, LanguageModel) and not quiet:
        tell(forecast(wanted, proposing, settings) + "\n")
    with machine.opened() as executor, watched(quiet) as observe:
        found = start(
            wanted,
            settings,
            designer=proposing,
            seed=seed,
            executor=executor,
            workers=machine.workers,
            out=machine.out,
            budget_steps=search.budget_steps,
            time_limit=search.seconds,
            containment=machine.containment,
            observe=observe,
            trackers=tracker or (),
            name=settings_name(search.preset, settings),
            start_from=[read_start(wanted, one) for one in search.start_from or ()],
            hint=hint,
        )

    if as_json:
        from robomore.report import as_data

        write_json(as_data(found))
    elif found.champion is not None:
        from robomore.cli.show import print_outcome

        print_outcome(found)
        if not found.final:
            write("\nThe time limit is over. The same command goes on from here.\n")
    if found.champion is None:
        tell(
            "robomore: the time limit was over before anything was trained; raise --time-limit, "
            "or give the same command again, which goes on from here\n"
        )
        return 1
    return 0
