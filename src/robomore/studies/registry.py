"""Studies by name. A new one is one file beside this one, and one line here."""

from __future__ import annotations

from robomore.registry import Registry
from robomore.studies.study import Study


def _fault(name: str, found: object) -> str:
    return "" if isinstance(found, Study) else "is no Study"


STUDIES: Registry[Study] = Registry(
    "study",
    "robomore.studies",
    {
        "comparison": "robomore.studies.comparison:COMPARISON",
        "ablation": "robomore.studies.ablation:ABLATION",
        "coarse-to-fine": "robomore.studies.ablation:COARSE_TO_FINE",
        "diversity": "robomore.studies.diversity:DIVERSITY",
        "heatmaps": "robomore.studies.heatmaps:HEATMAPS",
        "transfer": "robomore.studies.transfer:TRANSFER",
        "motivation": "robomore.studies.motivation:MOTIVATION",
        "robustness-gear": "robomore.studies.robustness:ROBUSTNESS_GEAR",
        "robustness-terrain": "robomore.studies.robustness:ROBUSTNESS_TERRAIN",
    },
    _fault,
)
