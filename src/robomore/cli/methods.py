"""`robomore methods`: the search methods that there are, and the options of each."""

from __future__ import annotations

import ast
import inspect
import textwrap
from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any, get_type_hints

import msgspec
from cyclopts import Parameter

from robomore.cli.output import console, write_json
from robomore.settings import in_words


@dataclass(frozen=True, slots=True)
class Option:
    """One option of a method.

    Attributes:
        name: as in `--method-option NAME=VALUE`.
        type: what values it takes, in words.
        default: its value if it is not given.
        meaning: in a sentence or two.
    """

    name: str
    type: str
    default: Any
    meaning: str


def methods(
    *names: str, as_json: Annotated[bool, Parameter("--json", negative="")] = False
) -> None:
    """List the search methods with their options.

    Parameters
    ----------
    names
        Names of methods; all by default.
    as_json
        Print JSON.
    """
    from robomore.search import METHODS

    chosen = [(name, METHODS.get(name)) for name in names] if names else METHODS.items()
    found = [(name, method, options_of(method.Settings)) for name, method in chosen]
    if as_json:
        write_json(
            [
                {
                    "name": name,
                    "summary": method.summary,
                    "needs_designer": method.needs_designer,
                    "options": [asdict(option) for option in options],
                }
                for name, method, options in found
            ]
        )
        return
    screen = console()
    for name, method, options in found:
        asks = "" if method.needs_designer else " (asks no designer)"
        screen.print(name, style="bold", end="")
        screen.print(f"  {method.summary}{asks}")
        for option in options:
            default = msgspec.json.encode(option.default).decode()
            screen.print(f"  {option.name}={default}  ({option.type})")
            for line in textwrap.wrap(option.meaning, 72):
                screen.print(f"      {line}")
        screen.print()
    screen.print(
        "These are the defaults; a preset sets some options to other values. Use them with\n"
        "robomore run TASK --method NAME --method-option OPTION=VALUE",
    )


def options_of(settings: type[Any]) -> list[Option]:
    """Return the options of a method's settings class, in its order."""
    hints = get_type_hints(settings, include_extras=True)
    meanings = _docstrings(settings)
    plain = settings()
    return [
        Option(
            field.name,
            in_words(hints[field.name]),
            msgspec.to_builtins(getattr(plain, field.name)),
            meanings.get(field.name, ""),
        )
        for field in fields(settings)
    ]


def _docstrings(cls: type[Any]) -> dict[str, str]:
    """Return the text under each field of a dataclass, those that it inherits among them."""
    found: dict[str, str] = {}
    for owner in reversed(cls.__mro__[:-1]):
        try:
            (body,) = ast.parse(textwrap.dedent(inspect.getsource(owner))).body
        except (OSError, TypeError):  # It was not written in a file.
            continue
        assert isinstance(body, ast.ClassDef)
        for field, text in zip(body.body, body.body[1:], strict=False):
            match field, text:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str(said))),
                ):
                    found[name] = " ".join(said.split())
    return found
