"""The port to a language model: a request goes in, a completion comes out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from robomore.types import Slot


@dataclass(frozen=True, slots=True)
class Message:
    """One turn of a conversation.

    Attributes:
        role: who speaks.
        text: what is said.
        images: PNG files that go with it, for models that can see.
    """

    role: Literal["system", "user", "assistant"]
    text: str
    images: tuple[bytes, ...] = ()


@dataclass(frozen=True, slots=True)
class Sampling:
    """How a model is asked to answer. `None` leaves a setting to the provider.

    Attributes:
        temperature: of the sampling; many reasoning models refuse to be told.
        max_output_tokens: where an answer is cut off.
        seed: of the sampling; few providers promise anything for it.
        effort: how long a reasoning model may think.
    """

    temperature: float | None = None
    max_output_tokens: int | None = None
    seed: int | None = None
    effort: Literal["minimal", "low", "medium", "high"] | None = None


@dataclass(frozen=True, slots=True)
class Request:
    """One question, with its place in a run.

    Attributes:
        slot: which proposal it is for; models ignore it, recordings are found by it.
        repair: 0, or how many answers in the same slot were sent back before.
        messages: the whole conversation so far.
        schema: JSON schema that a provider may enforce. The messages describe the same form in
            words, so a provider without schemas is asked with the same messages.
        sampling: settings of the answer.
    """

    slot: Slot
    repair: int
    messages: tuple[Message, ...]
    schema: dict[str, Any] | None = None
    sampling: Sampling = Sampling()


@dataclass(frozen=True, slots=True)
class Completion:
    """What a model answered, and what it took.

    Attributes:
        text: the answer; empty if the model had nothing to say.
        truncated: the provider cut the answer off at its length limit.
        input_tokens: as the provider counted them, or an estimate where it does not count.
        output_tokens: likewise, thinking included.
        cost: in US dollars; `None` where no price is known.
        seconds: from the first try to the answer.
        tries: requests sent until one succeeded; 0 for a recording.
        structured: the provider enforced the schema.
        verdict: what was found wrong with this very answer when it was recorded; `None` for an
            answer that is new.
    """

    text: str
    truncated: bool = False
    input_tokens: int = 0
    output_tokens: int = 0
    cost: float | None = None
    seconds: float = 0.0
    tries: int = 1
    structured: bool = False
    verdict: tuple[str, ...] | None = None


def unasked() -> None:
    """What a model asks before it sends a request where nobody keeps count."""


class ChatModel(Protocol):
    """A language model. May be asked from several threads at once.

    Attributes:
        name: stable across runs, for it is part of an exchange's key.
    """

    name: str

    def complete(self, request: Request, sending: Callable[[], None] = unasked) -> Completion:
        """Answer, retrying what is worth retrying.

        Args:
            request: what is asked.
            sending: called before each try is sent; it raises to forbid it.

        Raises:
            InputError: it can never work like this (wrong key, unknown model, refused request).
            ModelUnavailable: it did not answer within the bounded retries.
        """
        ...

    def cost(self, input_tokens: int, output_tokens: int) -> float | None:
        """Return the price of so many tokens in US dollars, `None` where no price is known."""
        ...
