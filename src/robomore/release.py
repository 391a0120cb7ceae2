"""Which RoboMoRe this is."""

VERSION = "0.3.0.dev0"
