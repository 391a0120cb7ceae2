"""What went wrong with an answer that arrived: the true reason, for the user and for the model."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from robomore.llm.model import Completion, Message

_MOST_BYTES_PER_TOKEN = 5.5
"""No tokenizer packs more bytes of our prompts into a token. Prose has about four and a half."""
_FEWEST_REPORTED = 400
"""No context is as short. A server that reports fewer tokens counts something else, such as those
that were not in its cache."""


@dataclass(frozen=True, slots=True)
class Trouble:
    """Why an answer cannot be used as it is.

    Attributes:
        to_user: the reason and the remedy.
        to_model: the reason, in words that the model can act on.
        lasting: whether the same request would most likely end in the same way.
    """

    to_user: str
    to_model: str
    lasting: bool


def trouble_with(completion: Completion) -> Trouble | None:
    """Return why `completion` holds no answer or only a part of one, `None` if it seems whole."""
    empty = not completion.reply.strip()
    match completion.ending:
        case "refusal":
            said = " ".join(completion.reply.split())[:200]
            return Trouble(
                f"the model refused to answer ({said!r}); choose another model",
                "you refused to answer; the question is about the shape and the motion of a "
                "simulated robot; answer with one design",
                lasting=True,
            )
        case "filter" if empty:
            return Trouble(
                "the provider's content filter withheld the answer; choose another model or "
                "provider",
                "the answer was withheld by a content filter; answer with the design alone",
                lasting=True,
            )
        case "filter":
            return Trouble(
                "the provider's content filter cut the answer off; choose another model or "
                "provider if that happens often",
                "the answer was cut off by a content filter; answer with the design alone",
                lasting=False,
            )
        case "thoughts":
            return Trouble(
                "the server sent thoughts and no answer (reasoning_content without content); "
                "lower --effort, or configure how the server separates thoughts from the answer",
                "the answer holds thoughts alone; end the thoughts and then write the design",
                lasting=False,
            )
    if completion.truncated and empty:
        return Trouble(
            f"the model used up its output tokens ({completion.output_tokens:,}) before it began "
            "to answer; raise --max-output-tokens, or let it think less with --effort low",
            "the answer was cut off at the length limit before it began; think less and answer "
            "with the design at once",
            lasting=True,
        )
    if completion.truncated:
        return Trouble(
            f"the answer was cut off at the length limit ({completion.output_tokens:,} output "
            "tokens); raise --max-output-tokens, or let the model think less with --effort low",
            "the answer was cut off at the length limit; answer more briefly",
            lasting=False,
        )
    if empty:
        return Trouble(
            "the answer is empty, and the server gave no reason; look into the server's log",
            "the answer is empty",
            lasting=False,
        )
    return None


def prompt_cut(messages: Sequence[Message], reported: int) -> str:
    """Return that a server read only a part of a prompt, or an empty text.

    Some servers (Ollama) cut a prompt to their context length without an error, and report how many
    tokens they read.

    Args:
        messages: the prompt.
        reported: tokens of it, as the server counted them.
    """
    if not _FEWEST_REPORTED <= reported < least_tokens(messages):
        return ""
    return (
        f"the server read {reported:,} tokens of a prompt of more than "
        f"{least_tokens(messages):,}: it cuts prompts to its context length; raise that (Ollama: "
        "OLLAMA_CONTEXT_LENGTH, llama.cpp: --ctx-size, vLLM: --max-model-len), or lower "
        "--history-tokens"
    )


def least_tokens(messages: Sequence[Message]) -> int:
    """Return a number of tokens that no tokenizer stays below, pictures left out."""
    text = "\n".join(message.text for message in messages)
    size = len(text.encode("utf-8", "replace"))
    # No tokenizer in use merges words.
    return round(max(size / _MOST_BYTES_PER_TOKEN, 0.9 * len(re.findall(r"\w+", text))))
