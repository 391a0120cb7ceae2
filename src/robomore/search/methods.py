"""Search methods by name. A new one is one file beside this one, and one line here."""

from __future__ import annotations

from dataclasses import is_dataclass

from robomore.registry import Registry
from robomore.search.method import SearchMethod
from robomore.settings import from_options
from robomore.types import MethodSettings


def _fault(name: str, found: object) -> str:
    missing = [
        part
        for part in ("Settings", "summary", "needs_designer", "provenance", "plan", "run")
        if not hasattr(found, part)
    ]
    if missing or not isinstance(found, type):
        return f"is no SearchMethod class ({', '.join(missing) or 'it is not a class'})"
    return "" if is_dataclass(found.Settings) else "has Settings that are no dataclass"  # type: ignore[attr-defined]


METHODS: Registry[type[SearchMethod]] = Registry(
    "method",
    "robomore.methods",
    {
        "robomore": "robomore.search.robomore:RoboMoRe",
        "random": "robomore.search.random:RandomSearch",
        "reference": "robomore.search.reference:ReferenceOnly",
        "slim-reference": "robomore.search.slim_reference:SlimReference",
        "eureka": "robomore.search.eureka:Eureka",
        "eureka-morphology": "robomore.search.eureka_morphology:EurekaMorphology",
        "bayesian": "robomore.search.bayesian:Bayesian",
        "cmaes": "robomore.search.cmaes:CMAES",
        "genetic": "robomore.search.genetic:Genetic",
        "map-elites": "robomore.search.map_elites:MapElites",
        "given": "robomore.search.given:Given",
    },
    _fault,
)


def make_method(settings: MethodSettings) -> SearchMethod:
    """Return the method that `settings` describe.

    Raises:
        InputError: there is no such method or option, or a value is out of range.
    """
    method = METHODS.get(settings.name)
    return method(from_options(method.Settings, settings.options, f"method {settings.name}"))
