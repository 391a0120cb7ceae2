"""Makes text that untrusted code wrote fit to be shown."""

from __future__ import annotations


def sanitize(text: str) -> str:
    """Return `text` with every character replaced that steers a terminal or cannot be encoded."""
    return "".join(
        c if c.isprintable() or c in "\n\t" else "\N{REPLACEMENT CHARACTER}" for c in text
    )
