"""A model of any provider, through the model classes of pydantic-ai (not through its agents)."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
import time
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, Literal, TypeVar, cast

from genai_prices import Usage, calc_price
from pydantic_ai.direct import model_request
from pydantic_ai.exceptions import UserError
from pydantic_ai.messages import (
    BinaryContent,
    ModelMessage,
    ModelRequest,
    ModelResponse,
    SystemPromptPart,
    TextPart,
    UserContent,
    UserPromptPart,
)
from pydantic_ai.models import Model, ModelRequestParameters
from pydantic_ai.output import OutputObjectDefinition
from pydantic_ai.settings import ModelSettings

from robomore.errors import InputError
from robomore.llm.errors import SchemaRefused, translate
from robomore.llm.http import MOST_TOKENS
from robomore.llm.model import Completion, Message, Request, Sampling, do_nothing
from robomore.llm.redaction import redact
from robomore.llm.retry import RetryPolicy, retry
from robomore.llm.tokens import estimate_prompt, estimate_tokens

_log = logging.getLogger(__name__)

T = TypeVar("T")


class PydanticAIModel:
    """A `ChatModel` on one of pydantic-ai's model classes.

    It sends a JSON schema until the provider refuses one. After that the prompt alone asks for the
    form of the answer.
    """

    def __init__(
        self,
        name: str,
        model: Model,
        price: tuple[float, float] | None,
        retry_policy: RetryPolicy,
        sleep: Callable[[float], object] = time.sleep,
        key_variable: str = "",
    ) -> None:
        """Wrap `model`. `price` is in US dollars per million input and output tokens.

        `key_variable` is the environment variable with the key, for an error about the key.
        """
        self.name = name
        self._model = model
        self._price = price
        self._retry_policy = retry_policy
        self._sleep = sleep
        self._key_variable = key_variable
        self._schemas = True
        self._reached = False
        self._loop = _Loop()

    def complete(
        self, request: Request, before_send: Callable[[], None] = do_nothing
    ) -> Completion:
        """Return the answer to `request` (see `ChatModel.complete`)."""
        started = time.monotonic()
        structured = request.schema is not None and self._schemas
        tries = 0

        def once(structured: bool) -> ModelResponse:
            nonlocal tries
            before_send()
            tries += 1
            return self._once(request, structured)

        try:
            response = retry(lambda: once(structured), self._retry_policy, self._sleep)
        except SchemaRefused as refused:
            # An answer without the schema shows that the provider refused the schema itself.
            response = retry(lambda: once(False), self._retry_policy, self._sleep)
            structured = self._schemas = False
            _log.warning(
                "%s takes no JSON schema (%s); the prompt alone asks for the form",
                self.name,
                refused,
            )
        text, ending = _content(response)
        usage = response.usage
        input_tokens, output_tokens = usage.input_tokens, usage.output_tokens
        counted = 0 < input_tokens <= MOST_TOKENS and 0 <= output_tokens <= MOST_TOKENS
        if usage.unmeasured_requests or not counted:
            input_tokens = estimate_prompt(request.messages)
            output_tokens = estimate_tokens(text)
        cost = self.cost(input_tokens, output_tokens)
        if self._price is None and cost is not None and counted and not usage.unmeasured_requests:
            # Cached input has its own price, which only the full usage shows.
            try:
                cost = float(response.cost().total_price)
            except (LookupError, ValueError):
                _log.debug("no exact price for this answer of %s", self.name)
        return Completion(
            # A server can send a key back. Replies are kept and shown.
            reply=redact(text),
            truncated=response.finish_reason == "length",
            input_tokens=input_tokens,
            output_tokens=output_tokens,
            cost=cost,
            seconds=time.monotonic() - started,
            tries=tries,
            structured=structured,
            ending=ending,
        )

    def cost(self, input_tokens: int, output_tokens: int) -> float | None:
        """Return the price of so many tokens in US dollars, or `None` if no price is known."""
        if self._price is not None:
            return (input_tokens * self._price[0] + output_tokens * self._price[1]) / 1e6
        usage = Usage(input_tokens=input_tokens, output_tokens=output_tokens)
        name, url, system = self._model.model_name, self._model.base_url, self._model.system
        # The URL names the provider best. Behind a proxy, the provider's name is all there is.
        for where in ({"provider_api_url": url}, {"provider_id": system}):
            try:
                return float(calc_price(usage, name, **where).total_price)
            except (LookupError, ValueError):
                _log.debug("no price for %s at %s", name, where)
        return None

    def _once(self, request: Request, structured: bool) -> ModelResponse:
        # Made outside of the `try`: a fault of ours is no odd answer.
        messages, settings = _messages(request.messages), self._settings(request.sampling)
        parameters = _parameters(request.schema if structured else None)
        try:
            response = self._loop.run(
                self._retry_policy.timeout,
                model_request(
                    self._model,
                    messages,
                    model_settings=settings,
                    model_request_parameters=parameters,
                ),
            )
        except UserError as error:
            # The library knows in advance that this model takes no schema, or no pictures.
            if structured:
                raise SchemaRefused(str(error)) from None
            raise InputError(f"{self.name} cannot be asked like this: {error}") from None
        except Exception as error:  # noqa: BLE001  # an odd answer ends in errors of all kinds
            url = str(self._model.base_url)
            raise translate(
                error, self.name, url, structured, self._reached, self._key_variable
            ) from None
        self._reached = True
        return response

    def _settings(self, sampling: Sampling) -> ModelSettings:
        settings: dict[str, Any] = {
            "timeout": self._retry_policy.timeout,
            "request_timeout": self._retry_policy.timeout,
            # Retries are counted and bounded by `retry`, so the library must not retry too.
            "max_retries": 0,
            # Asks OpenAI not to store the conversation.
            "openai_store": False,
            "temperature": sampling.temperature,
            "max_tokens": sampling.max_output_tokens,
            "seed": sampling.seed,
            "thinking": sampling.effort,
        }
        given = {name: value for name, value in settings.items() if value is not None}
        return cast(ModelSettings, given)


class _Loop:
    """An event loop in its own thread.

    The library's connections belong to one loop. Requests come from any thread, even from one that
    already runs a loop, as in a notebook.
    """

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lock = threading.Lock()

    def run(self, seconds: float, work: Coroutine[Any, Any, T]) -> T:
        """Return what `work` gives within so many seconds.

        The client's own limit is for each piece of an answer. A server that sends one byte a second
        never reaches it.
        """
        with self._lock:
            if self._loop is None:
                self._loop = asyncio.new_event_loop()
                threading.Thread(target=self._loop.run_forever, name="llm", daemon=True).start()
        future = asyncio.run_coroutine_threadsafe(asyncio.wait_for(work, seconds), self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise


def _content(
    response: ModelResponse,
) -> tuple[str, Literal["", "filter", "refusal", "thoughts"]]:
    """Return the text of an answer, and why it is incomplete.

    Some servers take an answer for thoughts, or for the call of a tool. It is read from there.
    """
    text = response.text or ""
    if response.finish_reason == "content_filter":
        refusal = (response.provider_details or {}).get("refusal")
        return (str(refusal), "refusal") if refusal else (text, "filter")
    if not text.strip() and response.tool_calls:
        return response.tool_calls[0].args_as_json_str(), ""
    thoughts = response.thinking or ""
    if not text.strip() and thoughts.strip() and response.finish_reason != "length":
        return thoughts, "thoughts"
    return text, ""


def _messages(messages: Sequence[Message]) -> list[ModelMessage]:
    converted: list[ModelMessage] = []
    parts: list[SystemPromptPart | UserPromptPart] = []
    for message in messages:
        if message.role == "assistant":
            converted += [ModelRequest(parts), ModelResponse([TextPart(message.text)])]
            parts = []
        elif message.role == "system":
            parts.append(SystemPromptPart(message.text))
        else:
            seen = [BinaryContent(image, media_type="image/png") for image in message.images]
            content: list[UserContent] = [message.text, *seen]
            parts.append(UserPromptPart(content if seen else message.text))
    return [*converted, ModelRequest(parts)]


def _parameters(schema: dict[str, Any] | None) -> ModelRequestParameters:
    if schema is None:
        return ModelRequestParameters()
    # Some adapters rewrite the schema in place.
    own = json.loads(json.dumps(schema))
    name = str(own.pop("title", "answer"))
    return ModelRequestParameters(
        output_mode="native", output_object=OutputObjectDefinition(json_schema=own, name=name)
    )
