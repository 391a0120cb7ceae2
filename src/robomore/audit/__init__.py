"""The audit: whether a design's number is worth believing, or comes from a fault of the simulator.

A search finds whatever gives a high number, and a simulator that gives energy for nothing is as
good as a good robot. An audit runs the kept policy again in the trusted measurement, where no
reward is loaded: with other numerics, with noise, with pushes, with other matter, and it looks into
the simulation for what cannot be. Each check is one small file and gives one verdict. Nothing is
trained anew.
"""

from robomore.audit.all_checks import audit
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.store.audit import Audit, Verdict

__all__ = ["Audit", "Subject", "Variant", "Verdict", "audit"]
