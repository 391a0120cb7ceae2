"""Makes a model from its name. Only here is the library of a provider imported, when needed."""

from __future__ import annotations

import inspect
import ipaddress
import os
import re
from functools import partial
from typing import TYPE_CHECKING, Any, cast
from urllib.parse import urlsplit

from robomore.errors import InputError
from robomore.llm.redaction import public_url
from robomore.llm.retry import RetryPolicy

if TYPE_CHECKING:
    from robomore.llm.client import PydanticAIModel

COMPATIBLE_KEY = "ROBOMORE_LLM_KEY"
"""Environment variable with the key for a `--base-url`. Keys of other providers are never sent to a
URL that the user chooses."""
_OLLAMA = "http://127.0.0.1:11434/v1"
_INSTALL = "pip install 'robomore[llm]'"


def connect(
    model: str,
    base_url: str | None = None,
    price: tuple[float, float] | None = None,
    retry_policy: RetryPolicy | None = None,
) -> PydanticAIModel:
    """Return the model with that name. Nothing is sent yet.

    Args:
        model: `PROVIDER:NAME`, such as `anthropic:NAME`; with `base_url`, the name that the server
            uses.
        base_url: URL of an OpenAI-compatible server, such as `http://127.0.0.1:8080/v1`.
        price: US dollars per million input and output tokens. It replaces the price list.
        retry_policy: how often a request is tried, and how long.

    Raises:
        InputError: the name, the key or the library is missing or wrong, with the remedy.
    """
    retry_policy = retry_policy or RetryPolicy()
    try:
        from robomore.llm.client import PydanticAIModel
        from robomore.llm.http import make_client

        client = make_client(retry_policy.timeout)
        if base_url is not None:
            library = _compatible(model, base_url, client)
        else:
            library = _known(model, client)
    except ImportError as error:
        raise InputError(_missing(error)) from None
    if price is None and _is_local(base_url or (_ollama() if model.startswith("ollama:") else "")):
        price = (0.0, 0.0)
    key_variable = COMPATIBLE_KEY if base_url is not None else ""
    return PydanticAIModel(model, library, price, retry_policy, key_variable=key_variable)


def _compatible(model: str, base_url: str, client: Any) -> Any:
    from pydantic_ai.models.openai import OpenAIChatModel
    from pydantic_ai.providers.openai_compatible import OpenAICompatibleProvider

    if urlsplit(base_url).scheme not in ("http", "https") or not urlsplit(base_url).hostname:
        raise InputError(
            f"--base-url {public_url(base_url)!r} is no URL; it looks like http://127.0.0.1:8080/v1"
        )
    if not model:
        raise InputError("--base-url needs --model NAME, the name under which the server serves it")
    # Servers without keys still expect a value in the header.
    key = os.environ.get(COMPATIBLE_KEY) or "none"
    provider = OpenAICompatibleProvider(
        "compatible", base_url=base_url, api_key=key, http_client=client
    )
    return OpenAIChatModel(model, provider=provider)


def _known(model: str, client: Any) -> Any:
    from pydantic_ai.exceptions import UserError
    from pydantic_ai.models import infer_model
    from pydantic_ai.models.ollama import OllamaModel
    from pydantic_ai.providers.ollama import OllamaProvider

    provider, colon, name = model.partition(":")
    if not colon or not provider or not name:
        raise InputError(
            f"model {model!r} is not PROVIDER:NAME; for example openai:NAME, anthropic:NAME, "
            "google:NAME or ollama:NAME, or give the --base-url of a compatible server"
        )
    if provider == "ollama":
        return OllamaModel(name, provider=OllamaProvider(base_url=_ollama(), http_client=client))
    try:
        return infer_model(model, partial(_provider, client=client))
    except ValueError:
        raise InputError(
            f"model {model!r} cannot be used: no provider is called {provider!r}"
        ) from None
    except UserError as error:
        variable = re.search(r"\b[A-Z][A-Z_]*_(?:KEY|TOKEN)\b", str(error))
        reason = f"model {model!r} cannot be used: " + str(error).partition("\n")[0]
        if variable:
            reason = f"{provider} needs its key in the environment: {variable[0]} is not set"
        raise InputError(reason) from None


def _provider(name: str, client: Any) -> Any:
    """Return a provider of the library, with our HTTP client if it takes one."""
    from pydantic_ai.providers import infer_provider, infer_provider_class

    made = infer_provider_class(name)
    if name.startswith("gateway/") or "http_client" not in inspect.signature(made).parameters:
        return infer_provider(name)
    # The parameters differ between providers, so the library does not declare them.
    return cast(Any, made)(http_client=client)


def _ollama() -> str:
    return os.environ.get("OLLAMA_BASE_URL") or _OLLAMA


def _is_local(base_url: str) -> bool:
    """Return whether a URL points to this machine, where tokens are free."""
    host = urlsplit(base_url).hostname or ""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _missing(error: ImportError) -> str:
    extra = re.search(r"pydantic-ai-slim\[([\w-]+)\]", str(error))
    if extra and extra[1] not in ("openai", "anthropic", "google"):
        return f"this provider needs one more package: pip install {extra[0]!r}"
    return f"a language model needs packages that are not installed: {_INSTALL}"
