"""A model that repeats what another run recorded: no network, no cost, the same answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from robomore.errors import InputError, ProposalFailed
from robomore.llm.exchange import Exchange, ExchangeLog, exchange_key
from robomore.llm.model import ChatModel, Completion, Request, unasked
from robomore.types import Slot


class ReplayModel:
    """A `ChatModel` that answers from recorded exchanges.

    Found by `content`, an exchange answers exactly the request that it answered before: a replayed
    run is the recorded one to the last digit, or it says where it parts from it. Found by `slot`,
    an exchange answers whatever is asked in its slot, so that a run with another trainer (other
    numbers in the history) can use the same proposals again. Its branches may then go further than
    the recorded ones did: for a slot of the fine stage that the recording lacks there is no
    proposal, and the search goes on without.
    """

    def __init__(
        self,
        log: ExchangeLog,
        by: Literal["content", "slot"] = "content",
        otherwise: ChatModel | None = None,
    ) -> None:
        """Make a model of a recorded run.

        Args:
            log: of the recorded run.
            by: what an exchange is found by.
            otherwise: is asked what the recording does not hold; `None` to refuse.

        Raises:
            InputError: the recording holds no exchanges, or those of several models.
        """
        exchanges = log.all()
        names = sorted({exchange.model for exchange in exchanges})
        if not names:
            raise InputError("the recorded run holds no exchanges with a language model to replay")
        if len(names) > 1 and by == "content":
            raise InputError(
                f"the recorded run holds exchanges with several models ({', '.join(names)}); "
                "they can be replayed by slot only"
            )
        self.name = otherwise.name if otherwise else names[0]
        self._recorded_name = names[0]
        self._by = by
        self._otherwise = otherwise
        self._by_key = {exchange.key: exchange for exchange in exchanges}
        self._by_slot: dict[tuple[Slot, int], Exchange] = {
            (exchange.slot, exchange.repair): exchange for exchange in exchanges
        }

    def complete(self, request: Request, sending: Callable[[], None] = unasked) -> Completion:
        """Answer from the recording; only what it does not hold is sent anywhere.

        Raises:
            InputError: the recording holds no such exchange, and there is no model besides.
            ProposalFailed: likewise, but the search can do without (see the class).
        """
        if self._by == "content":
            found = self._by_key.get(exchange_key(self._recorded_name, request))
        else:
            found = self._by_slot.get((request.slot, request.repair))
        if found is not None:
            # What was found wrong with a text stays true where the text is asked for exactly;
            # under another history it is judged anew.
            verdict = found.findings if self._by == "content" else None
            return Completion(
                found.reply,
                found.truncated,
                cost=0.0,
                tries=0,
                structured=found.structured,
                verdict=verdict,
            )
        if self._otherwise is not None:
            return self._otherwise.complete(request, sending)
        if self._by == "slot" and request.slot.stage == "fine":
            raise ProposalFailed(f"the recording holds no further answer for {request.slot}")
        raise InputError(self._missing(request))

    def cost(self, input_tokens: int, output_tokens: int) -> float | None:
        """Return 0: a recording costs nothing, or the price of the model besides."""
        return self._otherwise.cost(input_tokens, output_tokens) if self._otherwise else 0.0

    def _missing(self, request: Request) -> str:
        slot = request.slot
        if (slot, request.repair) in self._by_slot:
            return (
                f"the recording answers another prompt for {slot}: task, settings, seed and "
                "trainer must be those of the recorded run, or replay it by slot"
            )
        return (
            f"the recording ends before {slot} (attempt {slot.attempt}, repair {request.repair}); "
            "finish the recorded run, or ask for no more than it did"
        )
