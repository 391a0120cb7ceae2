"""RoboMoRe: co-design of robot bodies and rewards."""

__version__ = "0.1.0"
