"""How long a text is for a language model, without its tokenizer."""

from __future__ import annotations

from collections.abc import Iterable

from robomore.llm.model import Message

_BYTES_PER_TOKEN = 3.2
"""Prose has about four bytes to a token, code and numbers about three: a cautious middle."""
_TOKENS_PER_IMAGE = 800
_TOKENS_PER_MESSAGE = 6


def estimate_tokens(text: str) -> int:
    """Return about how many tokens `text` has; the same number on every machine.

    Prompts are fitted into budgets with this, and a prompt must not depend on whose tokenizer is
    installed: it is part of an exchange's key.
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
