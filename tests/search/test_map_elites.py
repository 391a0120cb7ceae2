"""The archive of MAP-Elites: cells, elites, and what was not measured."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robomore.errors import InputError
from robomore.search import make_method
from robomore.search.map_elites import MapElitesSettings, archive, cell_of
from robomore.types import Design, Evaluation, MethodSettings, Morphology, Reward
from search.fakes import evaluation

SETTINGS = MapElitesSettings(descriptors=("stride_frequency_hz", "ground_contact_share"), bins=4)


def moving(number: int, score: float | None, **behaviour: float) -> Evaluation:
    one = evaluation(Design(Morphology((float(number),)), Reward("1")), score)
    return replace(one, behaviour=behaviour)


@pytest.mark.parametrize(
    ("frequency", "contact", "cell"),
    [(0.0, 0.0, (0, 0)), (1.6, 0.3, (1, 1)), (5.9, 1.0, (3, 3)), (40.0, 0.5, (3, 2))],
)
def test_ranges_are_cut_into_bins(frequency: float, contact: float, cell: tuple[int, int]) -> None:
    one = moving(1, 1.0, stride_frequency_hz=frequency, ground_contact_share=contact)
    assert cell_of(one, SETTINGS) == cell


def test_a_cell_keeps_its_best_and_failures_fill_none() -> None:
    slow = {"stride_frequency_hz": 0.5, "ground_contact_share": 1.0}
    fast = {"stride_frequency_hz": 5.0, "ground_contact_share": 0.4}
    first, better, worse = moving(1, 2.0, **slow), moving(2, 3.0, **slow), moving(3, 1.0, **slow)
    other, failed, still = moving(4, 0.5, **fast), moving(5, None, **fast), moving(6, 9.0)
    found = archive([first, better, worse, other, failed, still], SETTINGS, "efficiency")
    assert found == {(0, 3): better, (3, 1): other}


def test_one_measure_twice_spans_no_archive() -> None:
    twice = {"descriptors": ["ground_contact_share", "ground_contact_share"]}
    with pytest.raises(InputError, match=r"one measure twice.*: joint_amplitude_rad, stride_freq"):
        make_method(MethodSettings("map-elites", twice))
