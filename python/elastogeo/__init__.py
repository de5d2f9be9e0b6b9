"""Elasto-geometric calibration of declared robots.

>>> import elastogeo
>>> found = elastogeo.identify("kr270-simulated")
>>> f"{found.rms['registration']:.2f} mm with base and tool fitted alone, {found.rms['after']:.2f} mm calibrated"
'0.83 mm with base and tool fitted alone, 0.19 mm calibrated'

Arrays are SI (m, rad, N, N.m), results as the commands print them (mm, deg; stiffnesses in SI).
"""

from ._native import Error, __version__
from .campaign import Campaign, Problem
from .commands import (
    compensate,
    compensator,
    diagnose,
    identifiability,
    identify,
    place,
    plan,
    register,
    report,
    residuals,
    sensitivity,
    simulate,
    stiffness,
    track,
    view,
)
from .effects import Effect
from .observations import Observation
from .robot import Robot, bundled_robots, rotation_vector

__all__ = [
    "Campaign",
    "Effect",
    "Error",
    "Observation",
    "Problem",
    "Robot",
    "__version__",
    "bundled_robots",
    "compensate",
    "compensator",
    "diagnose",
    "identifiability",
    "identify",
    "place",
    "plan",
    "register",
    "report",
    "residuals",
    "rotation_vector",
    "sensitivity",
    "simulate",
    "stiffness",
    "track",
    "view",
]
