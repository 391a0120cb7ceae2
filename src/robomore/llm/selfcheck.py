"""Checks that a model answers and can keep to a form: `robomore llm check`."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from robomore.errors import ModelUnavailable
from robomore.llm.model import ChatModel, Completion, Message, Request, Sampling
from robomore.llm.tokens import estimate_prompt
from robomore.llm.trouble import prompt_cut, trouble_with
from robomore.text import one_line
from robomore.types import Slot

_SCHEMA = {
    "title": "check",
    "type": "object",
    "properties": {"length": {"type": "number", "minimum": 0, "maximum": 10}},
    "required": ["length"],
    "additionalProperties": False,
}

_KEY = "length"

_FILLER = " ".join(["a", "e", "i", "o", "u"] * 1400)
"""As long as a prompt with a short history: each word is a token of every tokenizer."""
_WORD = "ready"
_FORM = '{"length": 2.5}'
_OTHER = "choose another model"
_LONGEST_QUOTE = 80
"""Characters of an answer that are shown."""


def _plain_json(text: str, wanted: str) -> dict[str, Any] | None:
    """Return the object that `text` is, if it is one with the key `wanted`."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) and wanted in found else None


@dataclass(frozen=True, slots=True)
class Check:
    """Result of two small requests.

    Attributes:
        model: name of the model.
        reply: its answer to a plain question, shortened.
        structured: `schema` if it keeps to a JSON schema, `wrapped` if something stands around
            the JSON or it is written otherwise, `words` if no schema was taken and it answers with
            JSON when asked in words, `no` if none of them.
        seconds: time for both answers.
        tokens: input and output tokens of both exchanges.
        cost: in US dollars, or `None` if no price is known.
        prompt_cut: that the server reads long prompts in part only, or empty.
        faults: what makes the answers unfit for a run, each with its remedy.
        note: what a user should know of answers that a run can use, or empty.
    """

    model: str
    reply: str
    structured: Literal["schema", "wrapped", "words", "no"]
    seconds: float
    tokens: int
    cost: float | None
    prompt_cut: str = ""
    faults: tuple[str, ...] = ()
    note: str = ""


def check(
    model: ChatModel,
    sampling: Sampling | None = None,
    find: Callable[[str, str], dict[str, Any] | None] = _plain_json,
    clean: Callable[[str], str] = str,
) -> Check:
    """Ask `model` two small questions, the first at the end of a long prompt.

    Args:
        model: what is asked.
        sampling: sampling settings of both requests.
        find: returns the JSON object in an answer that has a key, `None` without one; it should
            read answers as a run does.
        clean: removes from an answer what a run removes before it reads it.

    Raises:
        InputError: a request can never succeed; the message has the reason.
        ModelUnavailable: the model does not answer, or with nothing; the message has the reason.
    """

    def answer(index: int, text: str, schema: dict[str, Any] | None = None) -> Completion:
        slot = Slot("check", "check", (index,))
        completion = model.complete(
            Request(slot, 0, (Message("user", text),), schema, sampling or Sampling())
        )
        trouble = trouble_with(completion)
        if trouble and (trouble.lasting or not completion.reply.strip()):
            raise ModelUnavailable(f"{model.name} gave no answer: {trouble.to_user}")
        return completion

    long = f"Leave these letters aside: {_FILLER}\n\nAnswer with the single word: {_WORD}"
    plain = answer(0, long)
    messages = (Message("user", long),)
    # Without a count of the server, an estimate takes its place.
    counted = plain.input_tokens != estimate_prompt(messages)
    form = f"Answer with JSON alone, of the form {_FORM}, any number from 0 to 10."
    formed = answer(1, form, _SCHEMA)
    structured = _structure(formed, find)
    # A run reads answers that a server takes for thoughts, if a design is among them.
    as_thoughts = structured != "no" and formed.ending == "thoughts"
    troubles = [
        trouble_with(completion)
        for completion in (plain, formed)
        if not (as_thoughts and completion.ending == "thoughts")
    ]
    # Both answers can have the same trouble.
    faults = list(dict.fromkeys(trouble.to_user for trouble in troubles if trouble))
    if structured == "no" and not trouble_with(formed):
        faults.append(_not_as_asked(plain.reply, formed.reply))
    costs = (plain.cost, formed.cost)
    return Check(
        model=model.name,
        reply=one_line(clean(plain.reply))[:_LONGEST_QUOTE],
        structured=structured,
        seconds=plain.seconds + formed.seconds,
        tokens=sum(c.input_tokens + c.output_tokens for c in (plain, formed)),
        cost=None if None in costs else sum(cost or 0.0 for cost in costs),
        prompt_cut=prompt_cut(messages, plain.input_tokens) if counted else "",
        faults=tuple(faults),
        note="the server sends answers as thoughts (reasoning_content); they are read from there"
        if as_thoughts
        else "",
    )


def _not_as_asked(plain: str, formed: str) -> str:
    """Return what came in the place of the JSON that was asked for, and what to do."""
    if _WORD not in plain.lower():
        said = f"asked for the word {_WORD!r}, it answered {_quoted(plain)}, and "
        return f"{said}asked for JSON, {_quoted(formed)}; it refuses, or cannot follow: {_OTHER}"
    form = "JSON of another form" if _is_object(formed) else "no JSON"
    return f"asked for {_FORM}, it answered {_quoted(formed)}, which is {form}; {_OTHER}"


def _quoted(text: str) -> str:
    return repr(one_line(text)[:_LONGEST_QUOTE])


def _structure(
    completion: Completion, find: Callable[[str, str], dict[str, Any] | None]
) -> Literal["schema", "wrapped", "words", "no"]:
    found = find(completion.reply, _KEY)
    if found is None or not isinstance(found.get(_KEY), int | float):
        return "no"
    if not completion.structured:
        return "words"
    return "schema" if _plain_json(completion.reply, _KEY) == found else "wrapped"


def _is_object(text: str) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except (ValueError, RecursionError):
        return False
