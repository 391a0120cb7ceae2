"""Options for a language model on the command line, and the command `robomore llm check`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Group, Parameter

from robomore.cli.inputs import read_duration
from robomore.cli.output import write
from robomore.cli.whole import Whole
from robomore.errors import InputError, ModelUnavailable
from robomore.suggestions import no_such

if TYPE_CHECKING:
    from robomore.designers import LanguageModel, Replay
    from robomore.settings import RunSettings
    from robomore.tasks import Task

llm = App(name="llm", help="Check whether a language model can be used.")

_STRUCTURED = {
    "schema": "keeps to a JSON schema",
    "wrapped": "keeps to the form of a JSON schema, with something around it that a run removes",
    "words": "answers in JSON when asked in words; a schema is refused",
    "no": "no",
}
_TRIES_OF_CHECK = 2
_REMEDY_OF_CHECK = "look into the server's log, or check again later"


@Parameter(name="*", group=Group("Language model", sort_key=5))
@dataclass(frozen=True, kw_only=True)
class ModelOptions:
    """The language model that designs, how it is used, and what it may cost.

    Attributes
    ----------
    model
        PROVIDER:NAME (`openai:`, `anthropic:`, `google:`, `ollama:`), or NAME with `--base-url`.
    base_url
        URL of an OpenAI-compatible server, such as http://127.0.0.1:8080/v1.
    price
        IN,OUT in US dollars per million tokens, for a model without a known price.
    max_requests
        Stop before the run sends more requests than this.
    max_tokens
        Stop before the run uses more input and output tokens than this.
    max_cost
        Stop before the run costs more than this, in US dollars.
    parallel
        Requests that may run at once if they do not depend on each other.
    diversity
        Show each new proposal all earlier ones (Diversity Reflection).
    repairs
        How often an invalid answer is sent back with its errors.
    history_tokens
        The most tokens that the history in a prompt may take.
    history_rule
        How entries of the history are chosen, as names joined by +: best, worst, different, failed,
        recent. Each name in turn chooses one entry.
    vision
        Show the model pictures of the best design and of its motion.
    temperature
        Sampling temperature; by default the provider's.
    effort
        How long a reasoning model may think: minimal, low, medium or high.
    max_output_tokens
        Length at which an answer is cut off; by default the provider's.
    answer_time
        How long one answer may take, such as 90s or 10m. After that the request is sent once more,
        and then the run stops.
    """

    model: str = ""
    base_url: str | None = None
    price: str | None = None
    max_requests: Whole | None = None
    max_tokens: Whole | None = None
    max_cost: float | None = None
    parallel: Whole = 4
    diversity: bool = True
    repairs: Whole = 3
    history_tokens: Whole = 4000
    history_rule: str = "best+worst+different+failed"
    vision: Annotated[bool, Parameter(negative="")] = False
    temperature: float | None = None
    effort: Literal["minimal", "low", "medium", "high"] | None = None
    max_output_tokens: Whole | None = None
    answer_time: str = "10m"


@Parameter(name="*", group=Group("Replay", sort_key=6))
@dataclass(frozen=True, kw_only=True)
class ReplayOptions:
    """The recorded exchanges that a replay uses.

    Attributes
    ----------
    source
        Folder of the recorded run.
    by
        `content` answers exactly the prompts of that run, `slot` any prompt for the same slot.
    """

    source: Annotated[Path | None, Parameter("--from")] = None
    by: Literal["content", "slot"] = "content"


def chosen(
    designer: str | None, model: ModelOptions | None, replay: ReplayOptions | None
) -> str | LanguageModel | Replay | None:
    """Return the designer that was chosen. `None` stands for options that were not given.

    Raises:
        InputError: an option is missing, makes no sense or belongs to another designer.
    """
    from robomore.designers import DESIGNERS, LanguageModel, Replay

    if designer is None and model is None and replay is None:
        return None
    designer = designer or "offline"
    names = (*DESIGNERS, LanguageModel.name, Replay.name)
    if designer not in names:
        raise no_such("designer", designer, names)
    if model is not None and designer != LanguageModel.name:
        raise InputError(
            f"options of a language model were given, but the designer is {designer!r}; "
            "add --designer llm"
        )
    if replay is not None and designer != Replay.name:
        raise InputError(
            f"--from and --by were given, but the designer is {designer!r}; add --designer replay"
        )
    if designer == LanguageModel.name:
        return language_model(model or ModelOptions())
    if designer == Replay.name and replay is not None and replay.source is not None:
        return Replay(replay.source, replay.by)
    return designer


def language_model(options: ModelOptions) -> LanguageModel:
    """Return the model that the options describe. Nothing is sent yet.

    Raises:
        InputError: an option is missing or makes no sense.
    """
    from robomore.designers import LanguageModel
    from robomore.designers.llm.designer import LLMSettings
    from robomore.designers.llm.history import HistorySettings
    from robomore.llm import ModelBudget, Sampling, connect
    from robomore.llm.retry import RetryPolicy

    if not options.model:
        raise InputError(
            "which language model? add --model PROVIDER:NAME, or --base-url URL --model NAME"
        )
    for name in ("max_requests", "max_tokens", "max_cost", "max_output_tokens", "parallel"):
        value = getattr(options, name)
        if value is not None and not value > 0:
            raise InputError(f"--{name.replace('_', '-')} is {value}; give more than 0")
    settings = LLMSettings(
        diversity=options.diversity,
        repairs=options.repairs,
        history=HistorySettings(options.history_tokens, options.history_rule),
        sampling=Sampling(
            temperature=options.temperature,
            max_output_tokens=options.max_output_tokens,
            effort=options.effort,
        ),
    )
    budget = ModelBudget(options.max_requests, options.max_tokens, options.max_cost)
    policy = RetryPolicy(timeout=read_duration("answer-time", options.answer_time))
    model = connect(options.model, options.base_url, _price(options.price), policy)
    server = options.base_url or ""
    return LanguageModel(model, settings, budget, options.vision, server, options.parallel)


def forecast(task: Task, model: LanguageModel, settings: RunSettings) -> str:
    """Return one line on what a whole run usually asks of a model, and at most."""
    from robomore.designers.llm.estimate import estimate
    from robomore.designers.recorded import ATTEMPTS
    from robomore.search import SearchContext, make_method
    from robomore.types import Design, Morphology, Reward

    context = SearchContext(
        task=task,
        reference=Design(Morphology(task.reference), Reward(task.reward)),
        candidate=settings.candidate,
        evaluations=settings.evaluations,
    )
    proposals = make_method(settings.method).plan(context).proposals
    expected = estimate(task, model.settings, model.model.cost, proposals=proposals)
    most = sum(proposals.values()) * ATTEMPTS * (model.settings.repairs + 1)
    return (
        f"{model.model.name}: the whole run takes {expected}; up to {most} requests if many "
        "answers are invalid (--max-requests, --max-tokens and --max-cost limit that)"
    )


@llm.command
def check(*, model: ModelOptions | None = None) -> None:
    """Send two requests: does the model answer, read long prompts, and keep to a form?"""
    from robomore.designers.llm.extraction import object_in
    from robomore.designers.llm.thoughts import without_thoughts
    from robomore.llm import check as ask
    from robomore.llm import connect
    from robomore.llm.retry import RetryPolicy

    model = model or ModelOptions()
    asked = language_model(model)
    policy = RetryPolicy(
        max_tries=_TRIES_OF_CHECK,
        timeout=read_duration("answer-time", model.answer_time),
        remedy=_REMEDY_OF_CHECK,
    )
    found = ask(
        connect(model.model, model.base_url, _price(model.price), policy),
        asked.settings.sampling,
        object_in,
        without_thoughts,
    )
    cost = "price unknown" if found.cost is None else f"${found.cost:.4f}"
    write(
        f"model:   {found.model}\n"
        f"answers: {found.reply}\n"
        f"JSON:    {_STRUCTURED[found.structured]}\n"
        f"took:    {found.seconds:.1f} s, {found.tokens} tokens, {cost}\n"
    )
    if found.note:
        write(f"note:    {found.note}\n")
    faults = [fault for fault in (*found.faults, found.prompt_cut) if fault]
    if len(faults) > 1:
        faults = [f"({number}) {fault}" for number, fault in enumerate(faults, start=1)]
    if faults:
        raise ModelUnavailable(f"{found.model} is not ready for a run: {'; '.join(faults)}")


def _price(given: str | None) -> tuple[float, float] | None:
    if given is None:
        return None
    try:
        into, out = (float(number) for number in given.split(","))
    except ValueError:
        into = out = -1.0
    if not (0 <= into < math.inf and 0 <= out < math.inf):
        raise InputError(
            f"--price {given} is not IN,OUT; give US dollars per million tokens, such as 2.5,10"
        )
    return into, out
