"""The page's scripts say numbers as Python says them."""

from __future__ import annotations

import json
import random
import shutil
import subprocess

import pytest

from robomore.report.scripts import WEB
from robomore.runs.words import number

NODE = shutil.which("node")
SCRIPT = """
const { number } = await import(process.argv[1]);
let given = "";
for await (const part of process.stdin) given += part;
console.log(JSON.stringify(JSON.parse(given).map(([value, digits]) => number(value, digits))));
"""


def values() -> list[float | None]:
    """Return numbers of every size, and those at the edges of a rule or of a rounding."""
    draw = random.Random(0)
    edges = [0.0, -0.0, 584336.8, 0.000239, 12345678.0, 9.9996, 99_995.0, 999.95, 150.0, 1e7]
    # Half between two numbers, the larger or the smaller of which is even.
    halves = [12_345.0, 12_355.0, 0.00048828125, 2.0625, 2.1875, 123_450_000.0, 12_345.5]
    limits = [
        1e-5,
        9.99e-6,
        9.9999e-7,
        1e-9,
        9.9999e11,
        999_949_999_999.0,
        1e12,
        1e13,
        1e300,
        1e-300,
    ]
    sizes = [draw.uniform(1, 10) * 10.0**power for power in range(-12, 16) for _ in range(10)]
    known = [*edges, *halves, *limits, *sizes]
    return [None, *known, *(-value for value in known)]


@pytest.mark.skipif(NODE is None, reason="there is no Node")
@pytest.mark.parametrize("digits", [3, 4])
def test_numbers_are_those_of_python(digits: int) -> None:
    assert NODE is not None
    given = values()
    answer = subprocess.run(
        [NODE, "--input-type=module", "--eval", SCRIPT, "--", (WEB / "words.js").as_uri()],
        input=json.dumps([[value, digits] for value in given]),
        capture_output=True,
        text=True,
        check=True,
    )
    said = json.loads(answer.stdout)
    assert dict(zip(map(repr, given), said, strict=True)) == {
        repr(value): number(value, digits) for value in given
    }
