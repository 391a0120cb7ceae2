"""Text of somebody else's, made fit to be shown."""

from __future__ import annotations

from robomore.text import text_only


def test_text_of_somebody_else_is_no_markdown() -> None:
    assert text_only("a|b\n# <b>`x`</b>") == "a\\|b # &lt;b&gt;\\`x\\`&lt;/b&gt;"
    assert text_only("![i](http://x)") == "!\\[i\\](http://x)"
