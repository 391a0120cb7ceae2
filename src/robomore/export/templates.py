"""Texts of exported files, in `files/`: `@NAME@` stands for what differs from export to export."""

from __future__ import annotations

import re
from importlib.resources import files

_NAME = re.compile(r"@([A-Z_]+)@")


def template(name: str, **values: str) -> str:
    """Return the text of a file.

    Args:
        name: of the file that is written; its template is `files/NAME.txt`.
        values: by the names that the template uses, in small letters.

    Raises:
        KeyError: the template uses another name.
    """
    text = (files("robomore.export") / "files" / f"{name}.txt").read_text(encoding="utf-8")
    return _NAME.sub(lambda found: values[found[1].lower()], text)
