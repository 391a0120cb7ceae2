"""`robomore methods`: the ways to search, and the options of each."""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
from dataclasses import fields
from typing import Annotated, Any

from cyclopts import Parameter

from robomore.cli.output import write_json


def methods(*, as_json: Annotated[bool, Parameter("--json", negative="")] = False) -> None:
    """List the search methods and their options.

    Parameters
    ----------
    as_json
        Print JSON.
    """
    from robomore.search import METHODS

    found: list[dict[str, Any]] = [
        {
            "name": name,
            "summary": method.summary,
            "needs_designer": method.needs_designer,
            "options": _options(method.Settings),
        }
        for name, method in METHODS.items()
    ]
    if as_json:
        write_json(found)
        return
    lines = []
    for method in found:
        lines.append(f"{method['name']}: {method['summary']}")
        for option in method["options"]:
            lines.append(f"  {option['name']} = {option['default']}")
            lines += textwrap.wrap(
                option["meaning"], 76, initial_indent="      ", subsequent_indent="      "
            )
        lines.append("")
    lines.append("`robomore run TASK --method NAME --method-option OPTION=VALUE` uses one.")
    sys.stdout.write("\n".join(lines) + "\n")


def _options(settings: type[Any]) -> list[dict[str, Any]]:
    """Return the options of a settings class; the text below a field says what it means."""
    meanings = _texts_below_fields(settings)
    defaults = settings()
    return [
        {
            "name": field.name,
            "default": _plain(getattr(defaults, field.name)),
            "meaning": " ".join(meanings.get(field.name, "").split()),
        }
        for field in fields(settings)
    ]


def _plain(value: Any) -> str:
    """Return a default as it is given on the command line."""
    import msgspec

    return value if isinstance(value, str) else msgspec.json.encode(value).decode()


def _texts_below_fields(settings: type[Any]) -> dict[str, str]:
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(settings))).body
    except (OSError, SyntaxError, ValueError):
        return {}
    assert isinstance(tree, ast.ClassDef)
    found: dict[str, str] = {}
    for before, after in zip(tree.body, tree.body[1:], strict=False):
        match before, after:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                found[name] = text
    return found
