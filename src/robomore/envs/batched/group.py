"""Simulations for which a reward keeps things of the same form, so that they can run together."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robomore.envs import reward_state
from robomore.envs.batched import state as batched_state
from robomore.envs.batched.run import Run
from robomore.envs.batched.state import Form, Rows


@dataclass(frozen=True, slots=True)
class Group:
    """Some simulations and what the reward keeps in their `self`.

    Attributes:
        rows: which ones, in order.
        kept: by name, sorted.
        form: of what is kept.
    """

    rows: Rows
    kept: Mapping[str, Any]
    form: Form = ()

    def of(self, positions: Rows) -> Group:
        """Return the part of the group at some positions in it."""
        kept = {name: batched_state.selected(value, positions) for name, value in self.kept.items()}
        return Group(self.rows[positions], kept, self.form)

    def at(self, position: int) -> dict[str, Any]:
        """Return what the `self` of one simulation holds."""
        return {name: batched_state.single(value, position) for name, value in self.kept.items()}


def group(rows: Rows, kept: Mapping[str, Any], run: Run) -> Group:
    """Return simulations with what a reward left in their `self`.

    Raises:
        Refused: it left something that cannot be kept for several simulations.
    """
    ordered = {name: kept[name] for name in sorted(kept)}
    form = tuple((name, batched_state.form(value, run)) for name, value in ordered.items())
    return Group(rows, ordered, form)


def joined(groups: Iterable[Group], run: Run) -> list[Group]:
    """Return as few groups as possible, in the order of their first simulations."""
    alike: defaultdict[Form, list[Group]] = defaultdict(list)
    for one in groups:
        alike[one.form].append(one)
    whole = [parts[0] if len(parts) == 1 else _union(parts, run) for parts in alike.values()]
    return sorted(whole, key=lambda one: int(one.rows[0]))


def without(groups: Iterable[Group], gone: Rows) -> list[Group]:
    """Return the groups without the simulations that are `gone`."""
    left = ((one, np.flatnonzero(~np.isin(one.rows, gone))) for one in groups)
    return [one.of(positions) for one, positions in left if len(positions)]


def dump(groups: Sequence[Group]) -> bytes:
    """Return `groups` as text."""
    content = [
        [one.rows, {name: batched_state.encoded(value) for name, value in one.kept.items()}]
        for one in groups
    ]
    return reward_state.dump({"groups": content})


def load(text: bytes, run: Run) -> list[Group]:
    """Return what `dump` was given."""
    return [
        group(rows, {name: batched_state.decoded(v, run) for name, v in kept.items()}, run)
        for rows, kept in reward_state.load(text)["groups"]
    ]


def _union(parts: Sequence[Group], run: Run) -> Group:
    rows = np.sort(np.concatenate([part.rows for part in parts]))
    places = [np.searchsorted(rows, part.rows) for part in parts]
    kept = {
        name: batched_state.joined([part.kept[name] for part in parts], places, run)
        for name in parts[0].kept
    }
    return Group(rows, kept, parts[0].form)
