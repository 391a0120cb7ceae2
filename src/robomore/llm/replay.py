"""A model that answers from the exchanges of another run, without network and without cost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from robomore.errors import InputError, ProposalFailed
from robomore.llm.exchange import ExchangeLog, exchange_key
from robomore.llm.model import Completion, Request, do_nothing


class ReplayModel:
    """A `ChatModel` that answers from recorded exchanges.

    By `content`, an exchange answers only the very request that it answered before. A replayed run
    is then equal to the recorded one to the last digit, or it stops and says where it differs.

    By `slot`, an exchange answers any request for its slot. So a run with another trainer, whose
    history holds other numbers, can use the same proposals. Such a run may ask for more
    improvements than the recording holds. It gets no proposal for those slots and goes on.
    """

    def __init__(self, log: ExchangeLog, by: Literal["content", "slot"] = "content") -> None:
        """Make a model of a recorded run from the log of its exchanges.

        Raises:
            InputError: the recording has no exchanges, or by content those of several models.
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
        self.name = names[0]
        self._by = by
        self._by_key = {exchange.key: exchange for exchange in exchanges}
        self._by_slot = {(exchange.slot, exchange.repair): exchange for exchange in exchanges}

    def complete(
        self, request: Request, before_send: Callable[[], None] = do_nothing
    ) -> Completion:
        """Return the recorded answer.

        Raises:
            InputError: the recording has no such exchange.
            ProposalFailed: likewise, for an improvement in a replay by slot.
        """
        if self._by == "content":
            found = self._by_key.get(exchange_key(self.name, request))
        else:
            found = self._by_slot.get((request.slot, request.repair))
        if found is not None:
            # The same request leads to the same errors. With another history, the reply has to be
            # checked again.
            validation_errors = found.validation_errors if self._by == "content" else None
            return Completion(
                found.reply,
                found.truncated,
                cost=0.0,
                tries=0,
                structured=found.structured,
                validation_errors=validation_errors,
                ending=found.ending,
            )
        if self._by == "slot" and request.slot.improves:
            raise ProposalFailed(f"the recording has no answer for {request.slot}")
        slot = request.slot
        if (slot, request.repair) in self._by_slot:
            raise InputError(
                f"the recording answers another prompt for {slot}: task, settings, seed and "
                "trainer must be those of the recorded run, or replay it by slot"
            )
        raise InputError(
            f"the recording ends before {slot} (attempt {slot.attempt}, repair {request.repair}); "
            "finish the recorded run, or ask for no more than it did"
        )

    def cost(self, input_tokens: int, output_tokens: int) -> float | None:
        """Return 0, because recorded answers are free."""
        return 0.0
