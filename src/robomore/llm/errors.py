"""Turns the errors of pydantic-ai into ours: transient ones, and one clear line for the others."""

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

LIBRARY_ERRORS = (
    ModelAPIError,
    UnexpectedModelBehavior,
    IndexError,
    KeyError,
    TypeError,
    ValueError,
)
"""Errors that the library raises for a bad answer. The built-in ones come from answers of an
unexpected form: an empty list of choices is an IndexError."""

_TRANSIENT_STATUS = (408, 409, 425, 429)
_SCHEMA_STATUS = (400, 415, 422, 501)
"""HTTP statuses with which servers refuse a JSON schema."""


class SchemaRefused(Exception):
    """A request with a JSON schema was refused, perhaps because of the schema."""


def translate(error: Exception, name: str, url: str, structured: bool) -> Exception:
    """Return the error to raise instead of one of `LIBRARY_ERRORS`: a `TransientError` if a retry
    may help, `SchemaRefused` for a request with a JSON schema (`structured`), or `InputError`.
    """
    if not isinstance(error, ModelAPIError):
        return TransientError(_unreadable(error, name, url))
    match error:
        case ModelAuthenticationError():
            remedy = "check the key's environment variable (docs/llm.md)"
            return InputError(f"{name}: the key was refused; {remedy}")
        case ModelQuotaExceededError():
            return InputError(f"{name}: the account's quota is used up: {_message(error)}")
        case ModelContextWindowExceededError():
            remedy = "lower --history-tokens, or choose a model with a longer context"
            return InputError(f"{name}: the prompt is too long for this model; {remedy}")
        case ModelRateLimitError() | ModelOverloadedError():
            return TransientError(f"{name} is busy: {_message(error)}", error.retry_after)
        case ModelRequestTimeout() | ModelTimeoutError():
            return TransientError(f"{name} did not answer in time")
        case ModelConnectionError():
            reason = f"no connection to {name} at {url}: {_message(error)}"
            return TransientError(reason, error.retry_after)
    if not isinstance(error, ModelHTTPError):
        return TransientError(_unreadable(error, name, url))
    status = error.status_code
    if status in _TRANSIENT_STATUS or (status >= 500 and status != 501):
        reason = f"{name} failed with HTTP {status}: {_message(error)}"
        return TransientError(reason, error.retry_after)
    if structured and status in _SCHEMA_STATUS:
        return SchemaRefused(_message(error))
    if isinstance(error, ModelNotFoundError):
        close = f"; did you mean {error.suggested_model_id}?" if error.suggested_model_id else ""
        absent = f"{url} serves no model of the name in {name!r}"
        return InputError(f"{absent}: {_message(error)}{close}")
    return InputError(f"{name} refused the request with HTTP {status}: {_message(error)}")


def _unreadable(error: Exception, name: str, url: str) -> str:
    message = str(error)
    if isinstance(error, IndexError | KeyError):
        return f"{name} sent an answer without content"
    if "expected JSON data" in message or "Expected a JSON response" in message:
        return (
            f"{url} sent something that is no JSON (a web page?); the URL of a compatible server "
            "usually ends in /v1"
        )
    return f"{name} sent an answer that cannot be read: {_short(message)}"


def _message(error: ModelAPIError) -> str:
    """Return the provider's message, without what the library puts around it."""
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
    named = re.compile(r"(KEY|TOKEN|SECRET|PASSWORD)$")
    secrets = [value for name, value in os.environ.items() if named.search(name)]
    for secret in sorted((s for s in secrets if len(s) >= 6), key=len, reverse=True):
        line = line.replace(secret, "***")
    # Providers quote a key with its middle masked; the rest of the key is removed too.
    line = re.sub(r"\b(sk|key|AIza)[-_][\w*-]{4,}", "***", line)
    return line if len(line) <= 200 else line[:200] + "…"
