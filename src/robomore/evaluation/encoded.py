"""A batch of requests as executors take them, of any length."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import overload

from robomore.evaluation.request import Request
from robomore.text import to_json
from robomore.types import Job


class Encoded(Sequence[bytes]):
    """Requests that are encoded when their turn comes, so that memory does not grow with a batch.

    Args:
        jobs: by key.
        request: makes the request of a job.
    """

    def __init__(self, jobs: Mapping[str, Job], request: Callable[[str, Job], Request]) -> None:
        self._jobs = list(jobs.items())
        self._request = request

    def __len__(self) -> int:
        return len(self._jobs)

    @overload
    def __getitem__(self, index: int) -> bytes: ...
    @overload
    def __getitem__(self, index: slice) -> list[bytes]: ...
    def __getitem__(self, index: int | slice) -> bytes | list[bytes]:
        if isinstance(index, slice):
            return [self[n] for n in range(*index.indices(len(self)))]
        return to_json(self._request(*self._jobs[index]))
