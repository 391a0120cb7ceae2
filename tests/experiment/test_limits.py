"""Limits on volume and density: rules for whoever proposes, and no champion beyond them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import untrained  # noqa: F401  # makes its executor known
from robomore import run
from robomore.envs.compile import body_facts
from robomore.errors import InputError, InvalidMorphology, NothingTrained
from robomore.experiment.limits import limited
from robomore.options import with_options
from robomore.settings import preset
from robomore.tasks import get_task

SMOKE = with_options(preset("smoke"), max_volume=0.02)
HALF = 0.05
"""Less than half of the reference swimmer's volume, in m³."""


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"method": "genetic"},
        {"method": "eureka"},
        {"method_options": {"without": ["morphology"]}},
    ],
)
def test_no_design_of_a_search_is_larger_than_the_limit(
    options: dict[str, Any], tmp_path: Path
) -> None:
    settings = with_options(preset("smoke"), max_volume=HALF, **options)
    found = run("swimmer", settings, executor="untrained", out=tmp_path / "run")
    assert found.searched
    assert all(r.evaluation.volume <= HALF for r in found.searched if r.evaluation.ok)
    assert found.reference.volume > HALF, "the final still trains the reference beside it"
    assert found.champion.volume <= HALF
    assert any("beyond this run's limit of volume" in said for said in found.warnings)


TIGHT = 0.001
"""In m³: within the task's bounds, and with no morphology in its search ranges."""


def test_a_limit_beyond_the_search_ranges_is_for_those_who_draw_nothing(tmp_path: Path) -> None:
    options: dict[str, Any] = {"max_volume": TIGHT, "evaluations": 2}
    for refused in ({}, {"method": "random"}, {"method": "eureka-morphology"}):
        settings = with_options(preset("smoke"), **refused, **options)
        with pytest.raises(InputError, match=r"and the search ranges.*language model propose"):
            run("swimmer", settings, executor="untrained", out=tmp_path / "refused")
    assert not list(tmp_path.iterdir())
    ours = ({"method": "eureka"}, {"method_options": {"without": ["morphology"]}})
    for number, taken in enumerate(ours):
        settings = with_options(preset("smoke"), **taken, **options)
        found = run("swimmer", settings, executor="untrained", out=tmp_path / f"{number}")
        assert all(r.evaluation.volume <= TIGHT for r in found.searched)


@pytest.mark.parametrize("method", ["random", "genetic", "map-elites"])
def test_unlucky_draws_under_a_limit_end_no_search(method: str, tmp_path: Path) -> None:
    """At 0.005 m³ about one morphology in six is not found in 2,000 draws."""
    settings = with_options(preset("smoke"), method=method, evaluations=8, max_volume=0.005)
    found = run("swimmer", settings, executor="untrained", out=tmp_path)
    assert len([r for r in found.searched if r.evaluation.ok]) == 8
    assert all(r.evaluation.volume <= 0.005 for r in found.searched)


def test_a_method_that_has_only_the_reference_says_that_it_is_too_large(tmp_path: Path) -> None:
    settings = with_options(preset("smoke"), method="reference", max_volume=HALF)
    with pytest.raises(NothingTrained, match=r"a volume of 0\.1068 m³ is above the limit"):
        run("swimmer", settings, executor="untrained", out=tmp_path / "run")


def test_density_is_known_with_and_without_compiling() -> None:
    cheetah = get_task("half-cheetah")
    facts = body_facts(cheetah, cheetah.reference)
    settings = replace(SMOKE, max_volume=None, max_density=0.9 * facts["density"])
    searched = limited(cheetah, settings)
    with pytest.raises(InvalidMorphology, match=r"a density of 660\.9 kg/m³ is above the limit"):
        searched.check(cheetah.reference)
    thicker = {**cheetah.named(cheetah.reference), "torso_radius": 0.1}
    assert searched.check(thicker)
    # Mixed densities, so that nothing short of compiling tells.
    swimmer = get_task("swimmer")
    front = swimmer.template.index("front_radius")
    geom = swimmer.template.rindex("<geom", 0, front)
    mixed = swimmer.template[: geom + 5] + ' density="3000"' + swimmer.template[geom + 5 :]
    heavy = replace(swimmer, template=mixed)
    density = body_facts(heavy, swimmer.reference)["density"]
    assert density > 1001
    within = replace(settings, max_density=1.01 * density)
    assert limited(heavy, within).check(swimmer.reference)
    front_heavy = {**swimmer.named(swimmer.reference), "front_radius": 0.2}
    with pytest.raises(InvalidMorphology, match="a density of"):
        limited(heavy, within).check(front_heavy)


def test_limits_that_nothing_keeps_and_jumps_that_transport_nothing_are_refused(
    tmp_path: Path,
) -> None:
    with pytest.raises(InputError, match=r"limits: the volume .* 1e-07 m³; give larger"):
        run("swimmer", with_options(SMOKE, max_volume=1e-7), out=tmp_path / "a")
    with pytest.raises(InputError, match="transports nothing"):
        run("ant-jump", with_options(SMOKE, objective="transport-economy"), out=tmp_path / "b")
    assert not list(tmp_path.iterdir())
