"""Texts of exported files, in `files/`: `@NAME@` stands for what differs from export to export.

These files are executed, and a run's folder may come from anybody. So what a folder says stands in
them as a literal or as a name of letters and digits, or lies as data beside them.
"""

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
