"""Frames arrive whole however they are cut; malformed ones are refused."""

from __future__ import annotations

import os
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robomore.sandbox import wire
from robomore.sandbox.wire import (
    MAX_BODY,
    Frames,
    Kind,
    MalformedFrame,
    pack_number,
    send,
    unpack_number,
)


@given(
    st.lists(st.tuples(st.sampled_from(Kind), st.binary(max_size=50)), max_size=8),
    st.integers(1, 40),
)
def test_cut_anywhere(sent: list[tuple[Kind, bytes]], piece: int) -> None:
    reader, writer = os.pipe()
    for kind, body in sent:
        send(writer, kind, body)
    os.close(writer)
    frames, found = Frames(), []
    while arrived := os.read(reader, piece):
        found += frames.feed(arrived)
    os.close(reader)
    assert found == sent


@pytest.mark.parametrize(
    "nonsense", [b"\xff" * 5, struct.pack("<BI", Kind.REPLY, MAX_BODY + 1), b"\0" * 9]
)
def test_nonsense_is_refused(nonsense: bytes) -> None:
    with pytest.raises(MalformedFrame):
        Frames().feed(nonsense)


def test_a_flood_of_valid_frames_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wire, "MOST_BYTES", 2**22)  # so that it does not take a minute
    frames, flood = Frames(), (struct.pack("<BI", Kind.PROGRESS, 8) + bytes(8)) * 2**16
    with pytest.raises(MalformedFrame, match="MiB"):
        for _ in range(2**22 // len(flood) + 1):
            frames.feed(flood)


def test_numbers() -> None:
    assert unpack_number(pack_number(-(2**40))) == -(2**40)
    with pytest.raises(MalformedFrame):
        unpack_number(b"1234")
