"""The reference with thinner limbs: one scale for all radii, within bounds and rules."""

from __future__ import annotations

from dataclasses import replace

import pytest

from paper import PAPER
from robomore.errors import InputError
from robomore.experiment.limits import limited
from robomore.options import with_options
from robomore.search.slim_reference import SlimReference, SlimReferenceSettings, slim, thinnest
from robomore.settings import preset
from robomore.tasks import TASKS, get_task
from robomore.testing.methods import check_method

PLAIN = SlimReferenceSettings()


@pytest.mark.parametrize("task", PAPER)
def test_only_the_radii_are_scaled_and_all_alike(task: str) -> None:
    chosen = TASKS[task]
    found = slim(chosen, PLAIN)
    assert len(found) == PLAIN.values
    for morphology in found:
        named = chosen.named(morphology.parameters)
        scales = [
            named[p.name] / p.reference for p in chosen.parameters if p.name.endswith("radius")
        ]
        assert max(scales) < 1 and max(scales) - min(scales) < 1e-3
        assert all(
            named[p.name] == p.reference for p in chosen.parameters if not p.name.endswith("radius")
        )
    volumes = [chosen.volume(morphology.parameters) for morphology in found]
    assert volumes == sorted(volumes) and volumes[-1] < chosen.volume(chosen.reference)


def test_the_thinnest_is_at_a_bound_or_a_rule() -> None:
    cheetah = slim(get_task("half-cheetah"), PLAIN)[0]
    assert get_task("half-cheetah").named(cheetah.parameters)["head_radius"] < 0.0051
    # Swimmer's fluid allows no thinner link of 1 m than 0.017 m, whatever the bound says.
    swimmer = slim(get_task("swimmer"), PLAIN)[0]
    assert get_task("swimmer").named(swimmer.parameters)["front_radius"] == pytest.approx(
        0.017, rel=0.02
    )


def test_the_thinnest_is_the_reference_where_no_radius_could_be_smaller() -> None:
    swimmer = get_task("swimmer")
    assert thinnest(swimmer) == slim(swimmer, PLAIN)[0]
    fixed = replace(swimmer, shapes=lambda values: swimmer.solids(swimmer.named(swimmer.reference)))
    assert thinnest(fixed).parameters == swimmer.reference


def test_a_scale_that_is_given_is_held_to_the_task_s_own_bounds() -> None:
    swimmer = get_task("swimmer")
    widest = slim(swimmer, SlimReferenceSettings(thinnest=0.05))
    assert len(widest) == 6 and widest[0].parameters[3:] == (0.005, 0.005, 0.005)
    assert slim(swimmer, PLAIN)[0].parameters[3] > 0.016
    with pytest.raises(InputError, match=r"its bounds and rules allow 0\.05001 at the least"):
        slim(swimmer, SlimReferenceSettings(thinnest=0.04))


def test_scales_that_a_limit_refuses_are_named_with_what_refuses_them() -> None:
    swimmer = get_task("swimmer")
    tight = limited(swimmer, with_options(preset("smoke"), max_volume=0.005))
    with pytest.raises(InputError, match=r"none of the 6 scales from 0\.5 up .*limit of 0\.005 m³"):
        slim(tight, SlimReferenceSettings(thinnest=0.5))
    tighter = limited(swimmer, with_options(preset("smoke"), max_volume=0.001))
    with pytest.raises(InputError, match=r"no radii of swimmer thinner .* search ranges"):
        slim(tighter, PLAIN)
    kept = thinnest(tighter)
    assert tighter.check(kept.parameters) and "scaled into the run's limits" in kept.idea


def test_it_keeps_the_contract() -> None:
    check_method(lambda: SlimReference(PLAIN), get_task("ant"))


def test_a_scale_beyond_the_bounds_and_a_robot_without_radii_are_refused() -> None:
    with pytest.raises(InputError, match=r"scaled by 0\.01: .* allow 0\.10"):
        slim(get_task("half-cheetah"), SlimReferenceSettings(thinnest=0.01))
    swimmer = get_task("swimmer")
    fixed = replace(swimmer, shapes=lambda values: swimmer.solids(swimmer.named(swimmer.reference)))
    with pytest.raises(InputError, match="no parameter of swimmer sets a radius"):
        slim(fixed, PLAIN)
