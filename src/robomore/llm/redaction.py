"""Removes keys and passwords from texts that come from a server or go to people."""

from __future__ import annotations

import os
import re
from urllib.parse import quote, urlsplit, urlunsplit

_SECRET = re.compile(r"(KEY|TOKEN|SECRET|PASSWORD)$")
_SHORTEST = 6
"""Shorter values of environment variables are no keys. Removing them would damage other words."""
_LOGIN = re.compile(r"(?<=://)[^\s/@]+@")


def redact(text: str) -> str:
    """Return `text` without the values of environment variables that hold keys, and without the
    passwords of URLs."""
    values = {value.strip() for name, value in os.environ.items() if _SECRET.search(name)}
    secrets = {form for value in values for form in (value, quote(value, safe=""))}
    for secret in sorted((s for s in secrets if len(s) >= _SHORTEST), key=len, reverse=True):
        text = text.replace(secret, "***")
    return _LOGIN.sub("***@", text)


def redact_error(text: str) -> str:
    """Return the message of an error without keys, even without those that are partly masked."""
    # Providers quote a key with its middle masked; the rest of the key is removed too.
    return re.sub(r"\b(sk|key|AIza)[-_][\w*-]{4,}", "***", redact(text))


def public_url(url: str) -> str:
    """Return a URL without the parts that may be secret."""
    parts = urlsplit(url)
    return urlunsplit((parts.scheme, parts.netloc.rpartition("@")[2], parts.path, "", ""))
