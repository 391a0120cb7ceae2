"""Help texts that fill the terminal's lines, and not those of the docstrings they come from."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclopts.help import HelpPanel
    from rich.console import Console, ConsoleOptions

_BREAK = re.compile(r"(?<!\n)\n(?=\S)")
"""A break within a paragraph; empty lines, and breaks before indented lines, stay."""


class FlowingHelp:
    """Shows help as usual, with each paragraph as one text that breaks where the terminal ends."""

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        """Show one box of arguments, options or commands."""
        from cyclopts.help import DefaultFormatter

        for entry in panel.entries:
            _flow(entry.description)
        DefaultFormatter()(console, options, panel)

    def render_usage(self, console: Console, options: ConsoleOptions, usage: Any) -> None:
        """Show the first line."""
        from cyclopts.help import DefaultFormatter

        DefaultFormatter().render_usage(console, options, usage)

    def render_description(
        self, console: Console, options: ConsoleOptions, description: Any
    ) -> None:
        """Show what stands above the boxes."""
        from cyclopts.help import DefaultFormatter

        _flow(description)
        DefaultFormatter().render_description(console, options, description)


def _flow(shown: Any) -> None:
    """Take the breaks out of the paragraphs of a text that is to be shown, in place."""
    text = getattr(shown, "primary_renderable", None)
    if text is not None and hasattr(text, "plain"):
        text.plain = _BREAK.sub(" ", text.plain)
