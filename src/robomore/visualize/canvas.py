"""Matplotlib, imported when it is needed, and the colours that all figures share."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from robomore.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CHAMPION, REFERENCE, OTHER = "#c9701c", "#3a76b8", "#8a8d94"


def axes_for(ax: Axes | None) -> Axes:
    """Return `ax`, or the axes of a new figure.

    Raises:
        InputError: Matplotlib is not installed.
    """
    if ax is not None:
        return ax
    new: Axes = matplotlib("pyplot").subplots(layout="constrained")[1]
    return new


def matplotlib(module: str) -> Any:
    """Return a module of Matplotlib.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module(f"matplotlib.{module}")
    except ImportError as error:
        raise InputError(
            f"figures need Matplotlib, which cannot be imported ({error}); pip install "
            '"robomore[plot]"'
        ) from None
