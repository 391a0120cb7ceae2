"""Removes the thoughts that a reasoning model writes around its answer.

Models and servers mark thoughts in many ways: `<think>`, `[THINK]`, `◁think▷`, tags of a vendor,
special tokens, channels, fenced blocks. A mark is known by its words and not by its exact form, so
a new vendor's mark is understood too.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

_THINKING = ("think", "thought", "reason", "reflect", "scratchpad", "monologue", "brainstorm")
"""A mark with a word that contains one of these is about thoughts."""
_THINKING_WORDS = {"analysis", "commentary", "cot", "deliberation", "details", "draft", "planning"}
_ANSWER_WORDS = {"answer", "box", "final", "output", "response", "result", "solution"}

_MARK = re.compile(
    # A channel and its header, as gpt-oss and Gemma write it.
    r"<\|?channel\|?>\s*(?P<channel>\w*)(?:[^<\n]{0,60}<\|message\|>)?"
    # gpt-oss behind a server that removed the special tokens.
    r"|(?P<bare_final>assistant\s?final)"
    # A tag: <name …>, </name>, [NAME], <|name|>, ◁name▷.
    r"|(?P<bracket><\|?|<\uff5c|\[|◁)(?P<slash>/?)(?P<name>[A-Za-z][\w:▁-]{0,40})"
    r"(?P<attributes>\s[^<>\[\]\n]{0,200})?(?:\|?>|\uff5c>|\]|▷)"
    # The lines that Ollama prints around thoughts.
    r"|(?P<done>^\.{3}\s?done thinking\.?$)",
    re.MULTILINE,
)
_FENCED = re.compile(
    r"^(?P<fence>`{3,}|~{3,})(?:think|thinking|thoughts?|reasoning|analysis)\s*$", re.MULTILINE
)
_FENCE_LINE = re.compile(r"^[ \t]*(?:`{3,}|~{3,})[ \t]*([^`~\n]*)$", re.MULTILINE)
_HEADING = re.compile(
    r"^[ \t]*(?:[#>*_]+[ \t]*)*(?:here is my |my |the )?"
    r"(?:final\b[\w ]{0,30}|answer|response|solution|improved version|corrected version)"
    r"[ \t]*(?:[*_]+[ \t]*)?(?::|$)",
    re.IGNORECASE | re.MULTILINE,
)


@dataclass(frozen=True, slots=True)
class _Mark:
    """A place where thoughts or an answer begin or end. `name` tells pairs apart."""

    start: int
    end: int
    kind: Literal["thought", "answer", "other"]
    opens: bool
    name: str


def without_thoughts(text: str, wanted: str = "") -> str:
    """Return `text` without thoughts, and without the special tokens of a chat template.

    Several pieces may be left, as with a model that thinks twice. The last piece with the word
    `wanted` is returned, or else the last one that is not blank.
    """
    pieces = [piece.strip() for piece in _pieces(_without_fenced(text))]
    pieces = [piece for piece in pieces if piece]
    holding = [piece for piece in pieces if wanted in piece]
    return (holding or pieces or [""])[-1]


def after_final_heading(text: str) -> str | None:
    """Return what follows the last heading such as `Final answer:`, or `None` without one."""
    ends = [heading.end() for heading in _HEADING.finditer(text)]
    return text[ends[-1] :] if ends else None


def _pieces(text: str) -> list[str]:
    """Return what stands outside of thoughts."""
    marks = list(_marks(text))
    last_end = {m.name: i for i, m in enumerate(marks) if m.kind == "thought" and not m.opens}
    any_end = max(last_end.values(), default=-1)
    answers = [i for i, m in enumerate(marks) if m.kind == "answer" and m.opens]
    final = answers[-1] if answers else -1
    pieces: list[str] = []
    at, index = 0, 0
    while index < len(marks):
        mark = marks[index]
        pieces.append(text[at : mark.start])
        at = mark.end
        if mark.kind == "thought" and mark.opens:
            close = _closing(marks, index, last_end, any_end, final)
            if close is None:
                return pieces  # The answer was cut off within its thoughts.
            index, at = close, marks[close].end
            if marks[close].kind == "answer":
                pieces = []
        elif mark.kind == "thought" or (mark.kind == "answer" and mark.opens):
            # Some servers remove the opening mark of thoughts.
            pieces = []
        elif mark.kind == "answer":
            break
        index += 1
    else:
        pieces.append(text[at:])
    return pieces


def _closing(
    marks: list[_Mark], index: int, last_end: dict[str, int], any_end: int, final: int
) -> int | None:
    """Return the mark that ends the thoughts which begin at mark `index`.

    An end of the same name goes first, because thoughts can hold marks of other names.
    """
    name = marks[index].name
    same = last_end.get(name, -1) > index
    for i in range(index + 1, len(marks)):
        mark = marks[i]
        ends = mark.kind == "thought" and not mark.opens
        if ends and (mark.name == name or not same):
            return i
        if name == "channel" and final > index:
            if i == final:
                return i
        elif name == "channel" and mark.name == "":
            return i  # `<|end|>`
        if not same and any_end < i and i == final:
            return i
    return None


def _marks(text: str) -> Iterator[_Mark]:
    first = len(text) - len(text.lstrip())
    bare_channels = text.startswith("analysis", first)
    closed = set(re.findall(r"\[/([A-Za-z][\w:▁-]{0,40})\]", text))
    code = _code(text)
    for found in _MARK.finditer(text):
        start, end = found.span()
        if any(begin <= start < stop for begin, stop in code):
            continue
        if found["channel"] is not None:
            name = found["channel"].lower()
            kind = _kind(name)
            # `<channel|>` alone ends what a channel began.
            opens = bool(name)
            yield _Mark(start, end, "answer" if kind == "answer" else "thought", opens, "channel")
        elif found["bare_final"]:
            if bare_channels:
                yield _Mark(start, end, "answer", True, "channel")
        elif found["done"]:
            yield _Mark(start, end, "thought", False, "done")
        elif found["bracket"] != "[" or start == first or found["name"] in closed:
            # Code and lists hold words in square brackets as well.
            yield from _tag(found, text)


def _code(text: str) -> list[tuple[int, int]]:
    """Return where Python stands that defines a function, in fences or as the whole text.

    What looks like a mark within it belongs to a comment, a text or a comparison.
    """
    places, begin = [(0, len(text))] if "```" not in text else [], None
    for fence in _FENCE_LINE.finditer(text):
        if begin is not None and not fence[1]:
            places.append((begin, fence.start()))
            begin = None
        else:
            begin = fence.end()
    return [(a, b) for a, b in places if "def " in text[a:b] and _is_python(text[a:b])]


def _is_python(code: str) -> bool:
    try:
        ast.parse(textwrap.dedent(code))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return True


def _tag(found: re.Match[str], text: str) -> Iterator[_Mark]:
    name, bracket = found["name"], found["bracket"]
    words = [word for word in re.split(r"[\W_▁]+", name.lower()) if word]
    kind, opens = _kind(*words), not (found["slash"] or "end" in words)
    key = "".join(word for word in words if word not in ("begin", "start", "end", "of"))
    start, end = found.span()
    if bracket == "[":
        if kind == "thought":
            yield _Mark(start, end, kind, opens, key)
    elif kind == "other":
        # A token of the chat template: `<|im_end|>`, `<end_of_turn>`, `</s>`.
        if bracket in ("<|", "<\uff5c") or key in ("s", "turn"):
            yield _Mark(start, end, kind, opens, key)
        elif re.fullmatch(r"unused\d+", key):
            # MedGemma writes its thoughts between two unused tokens.
            opening = text.startswith("thought", end)
            yield _Mark(start, end, "thought", opening, "unused")
    elif found["attributes"] is None or name.lower() == "details" or "=" in found["attributes"]:
        yield _Mark(start, end, kind, opens, key)


def _kind(*words: str) -> Literal["thought", "answer", "other"]:
    for word in words:
        if word in _THINKING_WORDS or any(part in word for part in _THINKING):
            return "thought"
    return "answer" if _ANSWER_WORDS.intersection(words) else "other"


def _without_fenced(text: str) -> str:
    """Return `text` without fenced blocks whose language is a word for thoughts."""
    kept, at = [], 0
    for found in _FENCED.finditer(text):
        if found.start() < at:
            continue
        close = text.find(f"\n{found['fence']}\n", found.end())
        if close == -1:
            break
        kept.append(text[at : found.start()])
        at = close + len(found["fence"]) + 2
    return "".join([*kept, text[at:]])
