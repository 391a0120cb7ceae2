"""Turns the errors of pydantic-ai into ours: transient ones, and one clear line for the others."""

from __future__ import annotations

import errno
import json
import re
import socket
from collections.abc import Iterable, Iterator

from httpx2 import CloseError, ConnectTimeout, NetworkError, ProtocolError, ReadError
from pydantic import ValidationError
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
)

from robomore.errors import InputError, ModelUnavailable
from robomore.llm.http import AnswerTooLarge, OddAnswer, Redirected, WebPage, words_of_page
from robomore.llm.redaction import public_url, redact_error
from robomore.llm.retry import TransientError

_TRANSIENT_STATUS = (408, 409, 425, 429)
_TRIES_IN_TIME = 2
"""Tries of a request that is not answered in time. Each takes as long as a user has allowed."""
_SCHEMA_STATUS = (400, 415, 422, 501)
"""HTTP statuses with which servers refuse a JSON schema."""


class SchemaRefused(Exception):
    """A request with a JSON schema was refused, perhaps because of the schema."""


def translate(
    error: Exception, name: str, url: str, structured: bool, reached: bool, key_variable: str = ""
) -> Exception:
    """Return the error to raise instead of an error of the library.

    Args:
        error: anything that the library raised. Answers of an unexpected form end in errors of all
            kinds: an empty list of choices in an IndexError, deep nesting in a RecursionError.
        name: of the model.
        url: of its server.
        structured: whether the request had a JSON schema.
        reached: whether this server has answered before.
        key_variable: environment variable with the key, empty if unknown.

    Returns:
        A `TransientError` if a retry may help, `SchemaRefused` for a request with a JSON schema,
        `ModelUnavailable` if nobody listens at `url`, or `InputError`.
    """
    url = public_url(url)
    for cause in _causes(error):
        if isinstance(cause, AnswerTooLarge):
            return InputError(f"{name} sent {cause}; {url} is no server of language models")
        if isinstance(cause, Redirected):
            return InputError(
                f"{url} sends requests elsewhere ({_short(str(cause))}); nothing follows, because "
                "requests carry your key; if you trust that server, name it with --base-url (for "
                "ollama: OLLAMA_BASE_URL)"
            )
        if isinstance(cause, WebPage):
            said = f"{url} sent a web page ({_short(str(cause))!r}) in the place of an answer"
            if reached:
                return TransientError(said)
            return InputError(f"{said}; {_remedy_of_url(url)}")
        if isinstance(cause, OddAnswer):
            return TransientError(f"{name} at {url} sent {_short(str(cause))}")
        if not reached and _nobody_there(cause):
            return ModelUnavailable(
                f"no server answers at {url} ({_short(str(cause))}); start the server of {name}, "
                "or correct --base-url (for ollama: OLLAMA_BASE_URL)"
            )
    if isinstance(error, TimeoutError):
        return _late(name)
    if not isinstance(error, ModelAPIError):
        return TransientError(_unreadable(error, name, url))
    match error:
        case ModelAuthenticationError():
            where = key_variable or "the environment variable that docs/llm.md names"
            return InputError(f"{name}: the key was refused; set the right key in {where}")
        case ModelQuotaExceededError():
            return InputError(f"{name}: the account's quota is used up: {_message(error)}")
        case ModelNotFoundError() if page := _page(error):
            return InputError(
                f"{url} says HTTP 404 with a web page ({page!r}); {_remedy_of_url(url)}"
            )
        case ModelContextWindowExceededError():
            remedy = "lower --history-tokens, or choose a model with a longer context"
            return InputError(f"{name}: the prompt is too long for this model; {remedy}")
        case ModelRateLimitError() | ModelOverloadedError():
            return TransientError(f"{name} is busy: {_message(error)}", error.retry_after)
        case ModelTimeoutError() if any(isinstance(it, ConnectTimeout) for it in _causes(error)):
            return TransientError(f"{name} at {url} does not take the connection")
        case ModelRequestTimeout() | ModelTimeoutError():
            return _late(name)
        case ModelConnectionError():
            return TransientError(_cut_off(error, name, url), error.retry_after)
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


def _late(name: str) -> TransientError:
    said = f"{name} did not answer in time (--answer-time allows it longer)"
    return TransientError(said, most_tries=_TRIES_IN_TIME)


def _cut_off(error: ModelConnectionError, name: str, url: str) -> str:
    """Return what became of a connection; the library itself says "Connection error" of all."""
    causes = [it for it in _causes(error) if isinstance(it, NetworkError | ProtocolError)]
    said = next((text for it in reversed(causes) if (text := _short(str(it)))), "")
    if any(isinstance(it, ProtocolError | ReadError | CloseError) for it in causes):
        why = f" ({said.rstrip('.')})" if said else ""
        did = "took the request and closed the connection before it had answered"
        return f"{name} at {url} {did}{why}"
    return f"no connection to {name} at {url}: {said or _message(error)}"


def _causes(error: BaseException) -> Iterator[BaseException]:
    """Yield `error` and what it was raised from."""
    seen: BaseException | None = error
    for _ in range(20):
        if seen is None:
            return
        yield seen
        seen = seen.__cause__ or seen.__context__


def _nobody_there(cause: BaseException) -> bool:
    """Return whether a connection was refused, or its host has no address."""
    if isinstance(cause, socket.gaierror):
        return cause.errno != socket.EAI_AGAIN
    return isinstance(cause, OSError) and cause.errno == errno.ECONNREFUSED


def _unreadable(error: Exception, name: str, url: str) -> str:
    message = str(error)
    if isinstance(error, IndexError | KeyError):
        return f"{name} sent an answer without content"
    if "expected JSON data" in message or "Expected a JSON response" in message:
        return f"{url} sent something that is no JSON; {_remedy_of_url(url)}"
    for cause in _causes(error):
        if isinstance(cause, ValidationError):
            message = "; ".join(_fault(one["loc"], one["msg"]) for one in cause.errors()[:3])
    if isinstance(error, AttributeError | TypeError):
        message = "its form is not that of the protocol"
    return f"{name} sent an answer that cannot be read: {_short(message)}"


def _fault(field: Iterable[object], said: str) -> str:
    """Return what is wrong with which field of an answer."""
    return f"{'.'.join(map(str, field))}: {said[:1].lower()}{said[1:]}"


def _remedy_of_url(url: str) -> str:
    """Return what to do about a URL at which something else answers."""
    remedy = "correct --base-url (for ollama: OLLAMA_BASE_URL)"
    if re.search(r"/v\d", url):
        return remedy
    return f"{remedy}; that of a compatible server usually ends in /v1"


def _message(error: ModelAPIError) -> str:
    """Return the provider's message, without what the library puts around it."""
    body = error.body
    for field in ("error", "message", "detail"):
        if isinstance(body, dict) and field in body:
            body = body[field]
    if body is None or body == "":
        body = error.message
    if page := _page(error):
        return f"a web page in the place of an answer ({page!r})"
    return _short(body if isinstance(body, str) else json.dumps(body, default=str))


def _page(error: ModelAPIError) -> str:
    """Return the first words of a web page that came with an error, or an empty text."""
    body = getattr(error, "body", None) or error.message
    if not isinstance(body, str) or not re.search("<html|<!doctype", body, re.IGNORECASE):
        return ""
    return redact_error(words_of_page(body)) or "without words"


def _short(text: str) -> str:
    line = redact_error(" ".join(text.split()))
    return line if len(line) <= 200 else line[:200] + "…"
