"""How often a request is sent again."""

from __future__ import annotations

import pytest

from robomore.errors import ModelUnavailable
from robomore.llm.retry import RetryPolicy, TransientError, retry


def test_another_error_before_does_not_use_up_the_tries_of_a_late_answer() -> None:
    errors = [TransientError("busy"), TransientError("late", most_tries=2)]

    def call() -> str:
        if errors:
            raise errors.pop(0)
        return "answer"

    assert retry(call, RetryPolicy(), lambda seconds: None) == "answer"
    late = iter(range(9))

    def never() -> str:
        next(late)
        raise TransientError("late", most_tries=2)

    with pytest.raises(ModelUnavailable, match="tried 2 times"):
        retry(never, RetryPolicy(), lambda seconds: None)
    assert next(late) == 2
