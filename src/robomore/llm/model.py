"""The interface to a language model: a request goes in, a completion comes out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from robomore.types import Slot


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a conversation. `images` are PNG files, for models that can see."""

    role: Literal["system", "user", "assistant"]
    text: str
    images: tuple[bytes, ...] = ()


@dataclass(frozen=True, slots=True)
class Sampling:
    """Sampling settings of an answer. `None` leaves a setting to the provider.

    Attributes:
        temperature: sampling temperature. Many reasoning models refuse it.
        max_output_tokens: length in tokens at which the provider cuts an answer off.
        seed: sampling seed. Few providers promise anything for it.
        effort: how long a reasoning model may think.
    """

    temperature: float | None = None
    max_output_tokens: int | None = None
    seed: int | None = None
    effort: Literal["minimal", "low", "medium", "high"] | None = None


@dataclass(frozen=True, slots=True)
class Request:
    """One question to a model, with the slot of the run that it belongs to.

    Attributes:
        slot: the proposal that is asked for. Models ignore it; recordings are found by it.
        repair: how many answers for the same slot were sent back before this request.
        messages: the whole conversation so far.
        schema: JSON schema that a provider may enforce. The messages describe the same form in
            words, so a provider without schemas gets the same messages.
        sampling: sampling settings of the answer.
    """

    slot: Slot
    repair: int
    messages: tuple[Message, ...]
    schema: dict[str, Any] | None = None
    sampling: Sampling = Sampling()


@dataclass(frozen=True, slots=True)
class Completion:
    """The answer of a model, and what it took.

    Attributes:
        reply: text of the answer. It is empty if the model had nothing to say.
        truncated: whether the provider cut the answer off at its length limit.
        ending: why the answer is incomplete for another reason: a content filter, a refusal (the
            reply is its text), or thoughts without an answer (the reply is the thoughts).
        input_tokens: as the provider counted them, or an estimate if it does not count.
        output_tokens: likewise, tokens of thinking included.
        cost: in US dollars, or `None` if no price is known.
        seconds: time from the first try to the answer.
        tries: requests that were sent until one succeeded, 0 for a recorded answer.
        structured: whether the provider enforced the schema.
        validation_errors: errors in the reply. They are empty for an accepted reply, and `None`
            until the reply is checked. A recorded answer comes with its recorded errors.
    """

    reply: str
    truncated: bool = False
    input_tokens: int = 0
    output_tokens: int = 0
    cost: float | None = None
    seconds: float = 0.0
    tries: int = 1
    structured: bool = False
    validation_errors: tuple[str, ...] | None = None
    ending: Literal["", "filter", "refusal", "thoughts"] = ""


def do_nothing() -> None:
    """Allow a request to be sent, and do not count it: the default of `before_send`."""


class ChatModel(Protocol):
    """A language model. Several threads may use it at once.

    Attributes:
        name: the same in every run, because the key of an exchange contains it.
    """

    name: str

    def complete(
        self, request: Request, before_send: Callable[[], None] = do_nothing
    ) -> Completion:
        """Return the answer to `request`, and retry after transient errors.

        Args:
            request: what is asked.
            before_send: is called before each try. It raises to forbid the try.

        Raises:
            InputError: the request can never succeed (wrong key, unknown model, refused request).
            ModelUnavailable: the model did not answer within the bounded retries.
        """
        ...

    def cost(self, input_tokens: int, output_tokens: int) -> float | None:
        """Return the price of so many tokens in US dollars, or `None` if no price is known."""
        ...
