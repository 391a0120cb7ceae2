r"""Removes what models and servers wrap around a whole answer.

That is a Markdown quotation, LaTeX's `\boxed{…}`, and HTML entities. None of them is removed unless
the answer is inside it.
"""

from __future__ import annotations

import html
import re

_LONGEST_OBJECT = 20_000
"""Characters within which braces must close."""
_DEEPEST_QUOTE = 4

_QUOTE = re.compile(r"^ {0,3}> ?", re.MULTILINE)
_BOX = re.compile(r"\\f?box(?:ed)?\s*(?=\{)")
_MOST_BOXES = 20
_TEXT_IN_BOX = re.compile(r"\\(?:text|texttt|mathrm|mathtt)\s*(?=\{)")
_LATEX_ESCAPE = re.compile(r"\\([{}_#%&$])")
_ENTITY = re.compile(r"&(?:quot|apos|lt|gt|amp|nbsp|#\d{1,6}|#[xX][0-9a-fA-F]{1,6});")

_STRAIGHT = str.maketrans(
    dict.fromkeys("\u201c\u201d\u201e\u201f\u2033\uff02", '"')
    | dict.fromkeys("\u2018\u2019\u201a\u201b\u2032\uff07", "'")
)
"""Quotes of typography and of wide letters, which JSON and Python do not take."""


def without_quote(text: str, wanted: str) -> str:
    """Return `text` without the `>` of a quotation, if what is wanted stands in the quotation.

    A quotation beside an answer that stands outside of it is left as it is.
    """
    answer = re.compile(rf"""(?:["']|&quot;|\bdef\s+){re.escape(wanted)}\b""")
    for _ in range(_DEEPEST_QUOTE):
        lines = text.split("\n")
        quoted = "\n".join(line for line in lines if _QUOTE.match(line))
        others = "\n".join(line for line in lines if not _QUOTE.match(line))
        if not answer.search(quoted) or answer.search(others):
            return text
        text = _QUOTE.sub("", text)
    return text


def unboxed(text: str, wanted: str) -> str:
    r"""Return what `\boxed{…}` holds, if it holds what is wanted, or else `text`."""
    pieces: list[str] = []
    for found in list(_BOX.finditer(text))[:_MOST_BOXES]:
        piece = _within_braces(text, found.end())
        if inner := _TEXT_IN_BOX.match(piece):
            piece = _within_braces(piece, inner.end())
        piece = _LATEX_ESCAPE.sub(r"\1", piece).strip()
        if wanted in piece and piece not in pieces:
            # The braces of the box can be those of the object.
            pieces.append(f"{{{piece}}}" if piece.startswith(f'"{wanted}"') else piece)
    return "\n\n".join(pieces) or text


def without_entities(text: str) -> str:
    """Return `text` with characters in the place of HTML's names for them, such as `&lt;`."""
    for _ in range(2):  # some texts are escaped twice
        text = _ENTITY.sub(lambda entity: html.unescape(entity[0]), text)
    return text


def straightened(text: str) -> str:
    """Return `text` with the straight quotes of JSON and Python, not those of typography."""
    return text.translate(_STRAIGHT)


def closing_brace(text: str, start: int) -> int | None:
    """Return the end of the braces that open at `start`, with regard to strings and comments."""
    depth, at, quote = 0, start, ""
    while at < min(len(text), start + _LONGEST_OBJECT):
        character = text[at]
        if quote:
            if character == "\\":
                at += 1
            elif character == quote:
                quote = ""
        elif character == '"':
            quote = character
        elif character == "#" or text.startswith("//", at):
            at = text.find("\n", at)
            if at == -1:
                return None
        elif text.startswith("/*", at):
            at = text.find("*/", at) + 1
            if at == 0:
                return None
        elif character == "{":
            depth += 1
        elif character == "}":
            depth -= 1
            if depth == 0:
                return at + 1
        at += 1
    return None


def _within_braces(text: str, start: int) -> str:
    """Return what stands between the brace at `start` and its end, or the last brace."""
    end = closing_brace(text, start)
    return text[start + 1 : end - 1 if end else max(text.rfind("}"), start + 1)]
