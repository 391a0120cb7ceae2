"""What a server sends is looked at once, however it is made."""

from __future__ import annotations

import json
import time
from contextlib import suppress

import pytest

from robomore.llm.http import MOST_VALUES, AnswerTooLarge, WebPage, _check


@pytest.mark.parametrize("text", ['a "quoted" word', "back\\slash", "[{,}]" * 9_000, '\\"' * 9_000])
def test_text_counts_as_one_value(text: str) -> None:
    _check(json.dumps({"choices": [{"text": text}]}).encode())


def test_more_values_than_an_answer_has_are_refused() -> None:
    _check(json.dumps([0] * (MOST_VALUES - 1)).encode())
    with pytest.raises(AnswerTooLarge, match="5,001 values"):
        _check(json.dumps([0] * (MOST_VALUES + 1)).encode())


@pytest.mark.parametrize(
    "body",
    [b'{"' + b'\\"' * 500_000, b'{"' + b'\\\\"' * 300_000, b"<" * 10**6, b"<script " * 10**5],
)
def test_no_body_takes_long_to_look_at(body: bytes) -> None:
    began = time.process_time()
    with suppress(AnswerTooLarge, WebPage):
        _check(body)
    assert time.process_time() - began < 2
