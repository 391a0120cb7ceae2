"""Faults between us and a model: which may pass, and one line for each that does not."""

from __future__ import annotations

import json
import os
import re

from pydantic_ai.exceptions import (
    ModelAPIError,
    ModelAuthenticationError,
    ModelConnectionError,
    ModelContextWindowExceededError,
    ModelHTTPError,
    ModelNotFoundError,
    ModelOverloadedError,
    ModelQuotaExceededError,
    ModelRateLimitError,
    ModelRequestTimeout,
    ModelTimeoutError,
    UnexpectedModelBehavior,
)

from robomore.errors import InputError
from robomore.llm.retry import TransientError

FAULTS = (ModelAPIError, UnexpectedModelBehavior, IndexError, KeyError, TypeError, ValueError)
"""What the library raises for a bad answer: its own errors, and plain ones for answers in a shape
that it did not expect (an empty list of choices is an IndexError)."""

_PASSING_STATUS = (408, 409, 425, 429)
_SCHEMA_STATUS = (400, 415, 422, 501)


class SchemaRefused(Exception):
    """A request with a JSON schema was refused, and perhaps for it."""


def translate(error: Exception, name: str, url: str, structured: bool) -> Exception:
    """Return the error to raise in the place of the library's.

    Args:
        error: one of `FAULTS`.
        name: of the model.
        url: where it is served.
        structured: a JSON schema was sent along.

    Returns:
        `TransientError` for what may be gone next time, `SchemaRefused`, or an `InputError`.
    """
    if not isinstance(error, ModelAPIError):
        return TransientError(_unreadable(error, name, url))
    if isinstance(error, ModelAuthenticationError):
        return InputError(
            f"{name}: the key was refused; check the key's environment variable (docs/llm.md)"
        )
    if isinstance(error, ModelQuotaExceededError):
        return InputError(f"{name}: the account's quota is used up: {_said(error)}")
    if isinstance(error, ModelContextWindowExceededError):
        return InputError(
            f"{name}: the prompt is too long for this model; lower --history-tokens, or choose a "
            "model with a longer context"
        )
    if isinstance(error, ModelRateLimitError | ModelOverloadedError):
        return TransientError(f"{name} is busy: {_said(error)}", error.retry_after)
    if isinstance(error, ModelRequestTimeout | ModelTimeoutError):
        return TransientError(f"{name} did not answer in time")
    if isinstance(error, ModelConnectionError):
        return TransientError(
            f"no connection to {name} at {url}: {_said(error)}", error.retry_after
        )
    if not isinstance(error, ModelHTTPError):
        return TransientError(_unreadable(error, name, url))
    status = error.status_code
    if status in _PASSING_STATUS or (status >= 500 and status != 501):
        return TransientError(
            f"{name} failed with HTTP {status}: {_said(error)}", error.retry_after
        )
    if structured and status in _SCHEMA_STATUS:
        return SchemaRefused(_said(error))
    if isinstance(error, ModelNotFoundError):
        close = f"; did you mean {error.suggested_model_id}?" if error.suggested_model_id else ""
        return InputError(f"{url} serves no model of the name in {name!r}: {_said(error)}{close}")
    return InputError(f"{name} refused the request with HTTP {status}: {_said(error)}")


def _unreadable(error: Exception, name: str, url: str) -> str:
    said = str(error)
    if isinstance(error, IndexError | KeyError):
        return f"{name} sent an answer without content"
    if "expected JSON data" in said or "Expected a JSON response" in said:
        return (
            f"{url} sent something that is no JSON (a web page?); the URL of a compatible server "
            "usually ends in /v1"
        )
    return f"{name} sent an answer that cannot be read: {_short(said)}"


def _said(error: ModelAPIError) -> str:
    """Return what the provider said, without the library's frame around it."""
    body = error.body
    for field in ("error", "message", "detail"):
        if isinstance(body, dict) and field in body:
            body = body[field]
    if body is None or body == "":
        body = error.message
    text = body if isinstance(body, str) else json.dumps(body, default=str)
    if "<html" in text.lower() or "<!doctype" in text.lower():
        return "a web page instead of an answer; the URL of a compatible server usually ends in /v1"
    return _short(text)


def _short(text: str) -> str:
    line = " ".join(text.split())
    for secret in _secrets():
        line = line.replace(secret, "***")
    # What is left of a key that a provider quotes with its middle blotted out.
    line = re.sub(r"\b(sk|key|AIza)[-_][\w*-]{4,}", "***", line)
    return line if len(line) <= 200 else line[:200] + "…"


def _secrets() -> list[str]:
    named = re.compile(r"(KEY|TOKEN|SECRET|PASSWORD)$")
    values = (value for name, value in os.environ.items() if named.search(name))
    return sorted((value for value in values if len(value) >= 6), key=len, reverse=True)
