"""What a misspelt name may have meant: every error about a name that nothing has offers one."""

from __future__ import annotations

import builtins
import traceback
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType, TracebackType

from robomore.errors import InputError

_REFUSED = frozenset(
    (
        *("breakpoint", "compile", "delattr", "eval", "exec", "exit", "globals", "hash", "id"),
        *("input", "locals", "memoryview", "open", "quit", "setattr", "vars"),
    )
)
"""Python's own functions that `robomore.rewards.rules` refuses."""


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return ` Did you mean 'ant'?` for the name in `known` that is like `name`, or no text."""
    near = get_close_matches(str(name), list(known), n=1)
    return f" Did you mean {near[0]!r}?" if near else ""


def path_meant(path: Path) -> str:
    """Return ` Did you mean 'runs/ant'?` for a path to nothing, or no text.

    What is meant lies in the same folder and ends alike.
    """
    try:
        if path.exists():
            return ""
        names = [one.name for one in path.parent.iterdir() if one.suffix == path.suffix]
    except (OSError, ValueError):
        return ""
    near = get_close_matches(path.name, names, n=1)
    return f" Did you mean {str(path.parent / near[0])!r}?" if near else ""


def no_such(kind: str, name: object, known: Iterable[str]) -> InputError:
    """Return the error for a name that nothing has.

    Args:
        kind: what has such names, as in `preset`.
        name: that was given.
        known: all names that there are.
    """
    names = list(known)
    hint = did_you_mean(name, names)
    return InputError(f"no {kind} is called {name!r}.{hint} Choose one of {', '.join(names)}")


def meant(error: BaseException) -> str:
    """Return `. Did you mean 'square'?` for a name that untrusted code has misspelt, or no text.

    Args:
        error: an `AttributeError` of a module, or a `NameError`; all others give no text.
    """
    # Exact types alone: untrusted objects could answer with anything.
    if type(error) is AttributeError and type(error.obj) is ModuleType:
        known = [it for it in vars(error.obj) if type(it) is str and it[:1] != "_"]
    elif type(error) is NameError:
        known = [it for it in _names_at(error.__traceback__) if type(it) is str]
    else:
        return ""
    name = error.name
    if type(name) is not str:
        return ""
    hint = did_you_mean(name, known)
    return f".{hint}" if hint else ""


def _names_at(place: TracebackType | None) -> Iterator[object]:
    """Yield the names that the innermost line of a traceback could have used."""
    frames = [frame for frame, _ in traceback.walk_tb(place)]
    if frames:
        yield from frames[-1].f_code.co_varnames
        yield from frames[-1].f_globals
        yield from vars(builtins).keys() - _REFUSED
