"""Trying again what is worth trying again, a bounded number of times."""

from __future__ import annotations

import logging
import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from robomore.errors import ModelUnavailable

_log = logging.getLogger(__name__)

T = TypeVar("T")


class TransientError(Exception):
    """A fault that may be gone next time.

    Attributes:
        reason: in words, for the line that a user reads if it does not go away.
        wait: seconds that the provider asked for, `None` if it did not.
    """

    def __init__(self, reason: str, wait: float | None = None) -> None:
        super().__init__(reason)
        self.reason = reason
        self.wait = wait


@dataclass(frozen=True, slots=True)
class RetryPolicy:
    """How often and how long to try.

    Attributes:
        tries: requests sent in all for one answer.
        first_wait: seconds before the second try; doubles with each further one.
        longest_wait: seconds between two tries at most, unless the provider asks for more.
        longest_asked: the longest wait that a provider may ask for.
        seconds: until one request is given up.
    """

    tries: int = 6
    first_wait: float = 1.0
    longest_wait: float = 60.0
    longest_asked: float = 300.0
    seconds: float = 600.0

    def wait(self, tried: int) -> float:
        """Return the seconds to wait after `tried` tries, spread so that callers do not march."""
        # Timing decides no result, so this needs no seed.
        spread = random.uniform(0.75, 1.25)
        return min(self.longest_wait, self.first_wait * 2.0 ** (tried - 1)) * spread


def persist(
    attempt: Callable[[], T], patience: RetryPolicy, sleep: Callable[[float], object] = time.sleep
) -> T:
    """Return what `attempt` gives, trying again after a `TransientError` fault.

    Raises:
        ModelUnavailable: every try met a passing fault, or the provider asks for too long a wait.
    """
    for tried in range(1, patience.tries + 1):
        try:
            return attempt()
        except TransientError as fault:
            if fault.wait is not None and fault.wait > patience.longest_asked:
                raise ModelUnavailable(
                    f"{fault.reason}, and asks to wait {fault.wait:.0f} s; everything so far is "
                    "kept: run the same command again later"
                ) from None
            if tried == patience.tries:
                raise ModelUnavailable(
                    f"{fault.reason} (tried {tried} times); everything so far is kept: "
                    "run the same command again to go on"
                ) from None
            wait = max(fault.wait or 0.0, patience.wait(tried))
            _log.warning("%s; trying again in %.1f s", fault.reason, wait)
            sleep(wait)
    raise ValueError(f"patience without a try: {patience.tries}")
