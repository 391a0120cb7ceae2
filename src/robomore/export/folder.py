"""The folder that an export is written into: it alone, and nothing of anybody else's.

Everything is made before the first file is written. A folder with other content is refused. With
`force`, an earlier export in it is replaced: only what that export had written is removed, and only
if it is as it was written.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from robomore.errors import InputError
from robomore.plain_files import PlainFolder, cannot_write, is_plain_name
from robomore.text import listed, to_json

RECORD = "export.json"
"""Lists what an export wrote; its presence says that the folder is one."""

PARTS = ("README.md", "environment", "policy", "print", "robot", "video.mp4", "video.webp")
"""All that an export may write beside its record."""

_FORMAT = 1
_MOST_BYTES = 2**24
_REMEDY = "name another folder with --to"


def ensure_free(to: Path, force: bool) -> None:
    """Refuse a folder that cannot be written into, before anything is made.

    Args:
        to: the folder, which need not exist.
        force: whether an earlier export in it may be replaced.

    Raises:
        InputError: it holds something else, or an export and `force` is not given, or an export of
            which files were changed.
    """
    if to.exists() and not to.is_dir():
        raise InputError(f"{to} is a file; {_REMEDY}")
    files = PlainFolder(to)
    names = files.names()
    if not names:
        return
    if not _is_export(files):
        raise InputError(
            f"{to} is not empty and no export of RoboMoRe ({names[0]} is in it, and no {RECORD}); "
            f"{_REMEDY}"
        )
    if not force:
        raise InputError(f"{to} holds an export already; replace it with --force, or {_REMEDY}")
    for name in PARTS:
        if files.kind(name) == "folder":
            files.check(name, depth=4)
    if changed := _changed(files):
        raise InputError(
            f"{to} holds files that were changed after they were exported ({listed(changed)}); "
            f"move them away, or {_REMEDY}"
        )


def write_all(to: Path, content: Mapping[str, bytes], facts: Mapping[str, Any]) -> None:
    """Write the files of an export in the place of an earlier one's, and its record first.

    All other files in the folder stay.

    Args:
        to: the folder, after `ensure_free`.
        content: of each file by its path in the folder.
        facts: kept in the record, besides the digest of each file.

    Raises:
        InputError: a file cannot be written, or would take the place of one that no export wrote.
        ValueError: a path leads elsewhere.
    """
    if odd := [name for name in content if name.partition("/")[0] not in PARTS]:
        raise ValueError(f"{odd} is no part of an export")
    sums = {name: hashlib.sha256(content[name]).hexdigest() for name in sorted(content)}
    record = {"format": _FORMAT, "made_by": "robomore export", **facts, "sha256": sums}
    files = PlainFolder(to)
    earlier = _listed(files)
    if taken := [name for name in content if name not in earlier and files.kind(name)]:
        raise InputError(
            f"{to} holds files of your own where the export has one ({listed(taken)}); move them "
            f"away, or {_REMEDY}"
        )
    try:
        to.mkdir(parents=True, exist_ok=True)
        # Before the record that lists them: whatever ends this early, another try knows them.
        for name in earlier:
            files.remove(name)
        files.write(RECORD, json.dumps(json.loads(to_json(record)), indent=2).encode() + b"\n")
        for name, text in content.items():
            above, _, _ = name.rpartition("/")
            if above:
                files.make(above)
            files.write(name, text)
        for above in sorted({above for name in earlier for above in _above(name)}, reverse=True):
            if not files.names(above):
                files.remove(above)
    except OSError as error:
        raise cannot_write(to, error, _REMEDY) from None


def _listed(files: PlainFolder) -> dict[str, str]:
    """Return the digests of the files that an earlier export wrote, by name; none if there is none.

    The record may come from anybody, so nothing is taken from it that no export writes.
    """
    try:
        found = json.loads(files.read(RECORD, _MOST_BYTES))["sha256"]
    except (FileNotFoundError, ValueError, KeyError, TypeError):
        return {}
    return {
        name: str(digest)
        for name, digest in (found.items() if isinstance(found, dict) else ())
        if name.partition("/")[0] in PARTS and all(map(is_plain_name, name.split("/")))
    }


def _changed(files: PlainFolder) -> list[str]:
    """Return which files of an earlier export are no longer as it wrote them."""
    return [
        name
        for name, digest in _listed(files).items()
        if files.kind(name) == "folder"
        or (files.is_file(name) and hashlib.sha256(files.read(name)).hexdigest() != digest)
    ]


def _above(name: str) -> list[str]:
    """Return the folders in which a file lies, the innermost last."""
    parts = name.split("/")
    return ["/".join(parts[:count]) for count in range(1, len(parts))]


def _is_export(files: PlainFolder) -> bool:
    try:
        return bool(
            files.is_file(RECORD)
            and json.loads(files.read(RECORD, _MOST_BYTES))["made_by"] == "robomore export"
        )
    except (ValueError, KeyError, TypeError):
        return False
