"""Is there matter that the robot could be made of, and what would it do in the reference's?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.runs.warnings import STEEL
from robomore.runs.words import number
from robomore.store.audit import Outcome, Verdict

OSMIUM = 22_590.0
"""In kg/m³: nothing on earth is denser."""


def check(subject: Subject) -> Verdict:
    """Compare mass over volume with steel and with the densest matter there is."""
    density = subject.facts["density"]
    reference = subject.reference_facts["density"]
    outcome: Outcome = "fails" if density > OSMIUM else "warns" if density > STEEL else "passes"
    judged = {
        "fails": f"no matter is so dense (osmium has {number(OSMIUM)})",
        "warns": f"it would have to be denser than steel ({number(STEEL)})",
    }
    said = (
        f"{number(subject.facts['mass'])} kg in {number(subject.facts['volume'])} m³ is "
        f"{number(density)} kg/m³, the reference design has {number(reference)}"
    )
    if outcome in judged:
        said += f"; {judged[outcome]}"
    numbers = {"density_kg_m3": density, "reference_density_kg_m3": reference}
    return Verdict("implied density", outcome, f"{said}.", numbers)


def equal_density(subject: Subject) -> dict[str, float]:
    """Return what the robot does with the reference design's density and the same policy.

    Returns:
        `density` kg/m³ and `mass` kg; `fitness` m and `efficiency` m/m³ if the physics is stable.
    """
    facts, density = subject.facts, subject.reference_facts["density"]
    factor = density / facts["density"]
    # Where the task itself fixes the density, the two differ by rounding.
    variant = Variant() if abs(factor - 1) < 1e-6 else Variant(mass=factor)
    told = {"density": density, "mass": facts["mass"] * factor}
    found = subject.measured(variant)
    if found is None:
        return told
    return {**told, "fitness": found.fitness, "efficiency": found.fitness / facts["volume"]}
