"""A robot as a newcomer writes it: light shins, strong servos without ranges, no armature."""

from __future__ import annotations

from pathlib import Path

_LEGS = {"L": (0.15, 0.1), "R": (0.15, -0.1), "B": (-0.15, 0.0)}


def _leg(name: str, x: float, y: float) -> str:
    return f"""
      <body name="{name}_thigh" pos="{x} {y} 0">
        <joint name="{name}_hip" axis="0 1 0" range="-1 1"/>
        <geom type="capsule" size="0.015" fromto="0 0 0 0 0 -0.2" mass="0.1"/>
        <body name="{name}_shin" pos="0 0 -0.2">
          <joint name="{name}_knee" axis="0 1 0" range="-2.2 -0.4"/>
          <geom type="capsule" size="0.008" fromto="0 0 0 0 0 -0.2" mass="0.02"/>
        </body>
      </body>"""


_ALL = "".join(_leg(name, *place) for name, place in _LEGS.items())

SERVOS = "".join(
    f'<position name="{name}_{joint}" joint="{name}_{joint}" kp="30"/>'
    for name in _LEGS
    for joint in ("hip", "knee")
)

TRIPOD = f"""<mujoco model="tripod">
  <compiler angle="radian"/>
  <option timestep="0.005"/>
  <worldbody>
    <body name="trunk" pos="0 0 0.4">
      <freejoint/>
      <geom type="box" size="0.2 0.1 0.05" mass="4"/>{_ALL}
    </body>
  </worldbody>
  <actuator>{SERVOS}</actuator>
</mujoco>
"""

STEADY = TRIPOD.replace(
    "<option", '<default><joint armature="0.01" damping="0.2"/></default><option'
)
"""The same robot, which can be simulated."""


def write_tripod(folder: Path, text: str = STEADY) -> Path:
    (folder / "tripod.xml").write_text(text)
    return folder / "tripod.xml"
