"""Retries of requests that failed for a transient reason, a bounded number of times."""

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
    """An error that may be gone at the next try.

    Attributes:
        reason: the error in words, for the line that a user reads if it persists.
        retry_after: seconds that the provider asks to wait, or `None`.
        most_tries: tries that may end like this, whatever ended others, or `None` for those of
            the policy.
    """

    def __init__(
        self, reason: str, retry_after: float | None = None, most_tries: int | None = None
    ) -> None:
        super().__init__(reason)
        self.reason = reason
        self.retry_after = retry_after
        self.most_tries = most_tries


@dataclass(frozen=True, slots=True)
class RetryPolicy:
    """How often a request is tried, and how long each wait and each try may take.

    Attributes:
        max_tries: requests that are sent at most for one answer.
        initial_wait: seconds before the second try. The wait doubles with each further try.
        max_wait: longest wait between two tries in seconds, unless the provider asks for more.
        max_retry_after: longest wait in seconds that a provider may ask for.
        timeout: seconds after which one request is given up.
        remedy: what a user can do after the last try.
    """

    max_tries: int = 6
    initial_wait: float = 1.0
    max_wait: float = 60.0
    max_retry_after: float = 300.0
    timeout: float = 600.0
    remedy: str = "everything so far is kept: run the same command again to go on"

    def wait(self, tries: int) -> float:
        """Return the seconds to wait after so many tries, with a random jitter of 25 %.

        The jitter needs no seed, because timing decides no result.
        """
        jitter = random.uniform(0.75, 1.25)
        return min(self.max_wait, self.initial_wait * 2.0 ** (tries - 1)) * jitter


def retry(
    call: Callable[[], T], policy: RetryPolicy, sleep: Callable[[float], object] = time.sleep
) -> T:
    """Return what `call` returns, and call it again after a `TransientError`.

    Raises:
        ModelUnavailable: every try failed, or the provider asks for too long a wait.
        ValueError: the policy allows no try.
    """
    alike = 0
    for tries in range(1, policy.max_tries + 1):
        try:
            return call()
        except TransientError as error:
            alike += error.most_tries is not None
            if error.retry_after is not None and error.retry_after > policy.max_retry_after:
                raise ModelUnavailable(
                    f"{error.reason}, and asks to wait {error.retry_after:.0f} s; {policy.remedy}"
                ) from None
            believed = error.most_tries is not None and alike >= error.most_tries
            if believed or tries == policy.max_tries:
                raise ModelUnavailable(
                    f"{error.reason} (tried {tries} times); {policy.remedy}"
                ) from None
            wait = max(error.retry_after or 0.0, policy.wait(tries))
            _log.warning("%s; trying again in %.1f s", error.reason, wait)
            sleep(wait)
    raise ValueError(f"a retry policy needs at least one try: {policy.max_tries}")
