"""Estimates of how many tokens a text has, without the tokenizer of any model."""

from __future__ import annotations

from collections.abc import Iterable

from robomore.llm.model import Message

_BYTES_PER_TOKEN = 3.2
"""Prose has about four bytes per token, code and numbers about three. This is between them."""
_TOKENS_PER_IMAGE = 800
_TOKENS_PER_MESSAGE = 6


def estimate_tokens(text: str) -> int:
    """Return about how many tokens `text` has, the same number on every machine.

    Prompts are fitted into a token budget with this estimate. The prompt is part of an exchange's
    key, so it must not depend on which tokenizer is installed.
    """
    return round(len(text.encode("utf-8", "replace")) / _BYTES_PER_TOKEN + 0.5)


def estimate_prompt(messages: Iterable[Message]) -> int:
    """Return about how many tokens a conversation has."""
    return sum(
        estimate_tokens(message.text)
        + _TOKENS_PER_MESSAGE
        + _TOKENS_PER_IMAGE * len(message.images)
        for message in messages
    )
