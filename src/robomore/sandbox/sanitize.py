"""A stranger's words, made fit to be shown."""

from __future__ import annotations


def plain(text: str) -> str:
    """Return `text` without what could steer a terminal, end a line or fail to be encoded."""
    return "".join(
        c if c.isprintable() or c in "\n\t" else "\N{REPLACEMENT CHARACTER}" for c in text
    )
