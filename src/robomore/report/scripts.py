"""What makes a page move, inside the page itself: the scripts, packed data, and their policy.

The page allows the one script and the one style that it carries, by their digests, and nothing
from outside: text that somebody else wrote cannot run even if it were taken for markup.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from functools import cache
from html import escape
from pathlib import Path

WEB = Path(__file__).parent / "web"
BUNDLE = "bundle.js"
MARK = "<!-- scripts -->"
"""Stands in a template where scripts and data go, after all else."""


@cache
def bundle() -> str:
    """Return the scripts, as `make bundle` made them."""
    return (WEB / BUNDLE).read_text(encoding="utf-8")


@cache
def style() -> str:
    """Return the style of all pages."""
    return (WEB / "style.css").read_text(encoding="utf-8")


@cache
def policy() -> str:
    """Return the content security policy of a page that carries everything."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src '{_digest(bundle())}'",
            f"style-src-elem '{_digest(style())}'",
            # Places and colours of marks are attributes.
            "style-src-attr 'unsafe-inline'",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


def with_scripts(page: str, packs: Mapping[str, bytes]) -> str:
    """Return a page with the scripts and their data in it.

    Args:
        page: with `MARK` in it.
        packs: of `robomore.rendering.packing.pack`, by the name that a script asks for.
    """
    data = [
        f'<script type="application/octet-stream" data-pack="{escape(name, quote=True)}">'
        f"{base64.b64encode(pack).decode()}</script>\n"
        for name, pack in packs.items()
    ]
    before, _, after = page.partition(MARK)
    return "".join((before, *data, "<script>", bundle(), "</script>", after))


def _digest(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
