"""The bundle of the pages' scripts was made of the sources that lie beside it."""

from __future__ import annotations

import hashlib

from robomore.report.scripts import BUNDLE, WEB, bundle, style

_LONGEST = 300


def test_the_bundle_is_made_of_these_sources() -> None:
    sources = sorted(path for path in WEB.glob("*.js") if path.name != BUNDLE)
    text = b"".join(path.read_bytes() for path in (*sources, WEB / "package.json"))
    digest = hashlib.sha256(text).hexdigest()[:16]
    assert bundle().startswith(f"/* {digest}. "), "run `make bundle` and commit bundle.js"


def test_scripts_and_style_fit_into_a_page() -> None:
    assert "</script" not in bundle().lower()
    assert "<!--" not in bundle()
    assert "</style" not in style()
    # A page is cleaned of characters that steer a terminal; the digests must still fit.
    assert bundle().isascii()
    assert style().isascii()


def test_licence_and_sources_are_readable() -> None:
    assert "three.js authors" in (WEB / "THREE-LICENSE").read_text()
    assert "three.js" in bundle().splitlines()[0]
    for path in WEB.glob("*.js"):
        if path.name != BUNDLE:
            lines = path.read_text().splitlines()
            assert lines[0].startswith("//"), f"{path.name} says what it is for"
            assert len(lines) <= _LONGEST
            assert max(map(len, lines)) <= 240
