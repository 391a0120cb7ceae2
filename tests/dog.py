"""A small dog with servos, meshes that are only drawn and a keyframe, as people's files have it."""

from __future__ import annotations

from pathlib import Path

LEGS = {"FL": (0.2, 0.06), "FR": (0.2, -0.06), "RL": (-0.2, 0.06), "RR": (-0.2, -0.06)}


def leg(name: str, x: float, y: float) -> str:
    return f"""
      <body name="{name}_thigh" pos="{x} {y} 0">
        <inertial pos="0 0 -0.1" mass="0.8" diaginertia="0.003 0.003 0.0004"/>
        <joint name="{name}_hip" axis="0 1 0" range="-0.7 2.5"/>
        <geom class="visual"/>
        <geom name="{name}_upper" type="capsule" size="0.02" fromto="0 0 0 0 0 -0.2"/>
        <body name="{name}_calf" pos="0 0 -0.2">
          <inertial pos="0 0 -0.1" mass="0.2" diaginertia="0.001 0.001 0.0001"/>
          <joint name="{name}_knee" axis="0 1 0" range="-2.7 -0.9"/>
          <geom type="capsule" size="0.015" fromto="0 0 0 0 0 -0.2"/>
          <geom name="{name}_foot" type="sphere" size="0.02" pos="0 0 -0.2"/>
        </body>
      </body>"""


SERVOS = "".join(
    f'<position name="{name}_{joint}" joint="{name}_{joint}" kp="40" kv="1" '
    f'ctrlrange="{low} {high}" forcerange="-20 20"/>'
    for name in LEGS
    for joint, low, high in (("hip", -0.7, 2.5), ("knee", -2.7, -0.9))
)

DOG = f"""<mujoco model="dog">
  <compiler angle="radian" autolimits="true"/>
  <option integrator="implicitfast"/>
  <default>
    <default class="visual">
      <geom type="mesh" mesh="shell" contype="0" conaffinity="0" group="2"/>
    </default>
  </default>
  <asset><mesh name="shell" file="shell.obj"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="10 10 0.1"/>
    <geom name="wall" type="box" size="1 0.1 1" pos="0 5 0"/>
    <body name="trunk" pos="0 0 0.4">
      <freejoint name="root"/>
      <inertial pos="0 0 0" mass="5" diaginertia="0.03 0.06 0.07"/>
      <geom name="trunk" type="box" size="0.2 0.05 0.05"/>
      <site name="imu"/>{"".join(leg(name, x, y) for name, (x, y) in LEGS.items())}
    </body>
  </worldbody>
  <actuator>{SERVOS}</actuator>
  <sensor><gyro name="gyro" site="imu"/></sensor>
</mujoco>
"""

SHELL = """v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""

ARM = """<robot name="arm">
  <link name="base">
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 0.15"/><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.15"/><geometry><cylinder radius="0.03" length="0.3"/></geometry>
    </collision>
  </link>
  <link name="tool">
    <inertial>
      <origin xyz="0 0 0.05"/><mass value="0.2"/>
      <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.05"/>
      <geometry><mesh filename="package://arm/shell.obj"/></geometry>
    </collision>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.05"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="30" velocity="3"/>
  </joint>
  <joint name="flange" type="fixed">
    <parent link="upper"/><child link="tool"/><origin xyz="0 0 0.3"/>
  </joint>
</robot>
"""  # noqa: E501


def write_dog(folder: Path, text: str = DOG) -> Path:
    (folder / "shell.obj").write_text(SHELL)
    (folder / "dog.xml").write_text(text)
    return folder / "dog.xml"


def write_arm(folder: Path) -> Path:
    (folder / "shell.obj").write_text(SHELL)
    (folder / "arm.urdf").write_text(ARM)
    return folder / "arm.urdf"
