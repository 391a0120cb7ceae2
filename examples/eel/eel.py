"""Eel: a robot of your own as a task of RoboMoRe, in one file.

Four links in a row swim in a viscous plane, thick at the head and thin at the tail. It moves,
observes and ends its episodes as Gymnasium's Swimmer does, so that class is used as it is.
"""

from __future__ import annotations

from robomore.tasks import Parameter, Rule, Task, Values

REWARD = '''def _get_rew(self, x_velocity, action):
    """Forward speed less the cost of effort."""
    forward = self._forward_reward_weight * x_velocity
    effort = self.control_cost(action)
    return forward - effort, {"forward": forward, "effort": -effort}
'''

# What stands in braces is arithmetic over the parameters' names, computed for each morphology.
TEMPLATE = """\
<mujoco model="eel">
  <compiler angle="degree" inertiafromgeom="true"/>
  <option integrator="RK4" timestep="0.01" density="4000" viscosity="0.1"/>
  <default>
    <joint armature="0.1"/>
    <geom contype="0" conaffinity="0" rgba="0.25 0.45 0.40 1"/>
    <motor ctrllimited="true" ctrlrange="-1 1" gear="60"/>
  </default>
  <worldbody>
    <light directional="true" dir="0 0 -1" pos="0 0 4"/>
    <geom name="floor" type="plane" pos="0 0 -0.1" size="40 40 0.1" rgba="0.9 0.9 0.9 1"/>
    <body name="head">
      <camera name="track" mode="trackcom" pos="0 -3 3" xyaxes="1 0 0 0 1 1"/>
      <joint name="slider1" type="slide" axis="1 0 0"/>
      <joint name="slider2" type="slide" axis="0 1 0"/>
      <joint name="free_body_rot" type="hinge" axis="0 0 1"/>
      <geom name="head_geom" type="capsule" fromto="0 0 0 {-link_length} 0 0" size="{head_radius}"/>
      <body name="front" pos="{-link_length} 0 0">
        <joint name="neck" type="hinge" axis="0 0 1" limited="true" range="-100 100"/>
        <geom name="front_geom" type="capsule" fromto="0 0 0 {-link_length} 0 0" size="{(2 * head_radius + tail_radius) / 3}"/>
        <body name="back" pos="{-link_length} 0 0">
          <joint name="waist" type="hinge" axis="0 0 1" limited="true" range="-100 100"/>
          <geom name="back_geom" type="capsule" fromto="0 0 0 {-link_length} 0 0" size="{(head_radius + 2 * tail_radius) / 3}"/>
          <body name="tail" pos="{-link_length} 0 0">
            <joint name="tail_root" type="hinge" axis="0 0 1" limited="true" range="-100 100"/>
            <geom name="tail_geom" type="capsule" fromto="0 0 0 {-link_length} 0 0" size="{tail_radius}"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="neck"/>
    <motor joint="waist"/>
    <motor joint="tail_root"/>
  </actuator>
</mujoco>
"""  # noqa: E501


def thickens(values: Values) -> str | None:
    """Say what is wrong with a tail that is thicker than the head."""
    head, tail = values["head_radius"], values["tail_radius"]
    if tail <= head:
        return None
    return f"tail_radius = {tail:g} m is more than head_radius = {head:g} m"


EEL = Task(
    id="eel",
    title="Eel",
    description=(
        "The eel is a chain of four equally long links in a horizontal plane, immersed in a fluid "
        "that resists every motion. Its links are thickest at the head and thinnest at the tail. "
        "Three motors turn the three hinges between the links. The goal is to swim forward, in the "
        "direction of +x (to the right), by choosing the torques on the three hinges."
    ),
    fitness="distance",
    template=TEMPLATE,
    parameters=(
        Parameter("link_length", 0.1, 1.0, 0.5, "length of each link", scale="log"),
        Parameter("head_radius", 0.01, 0.3, 0.1, "radius of the first link", scale="log"),
        Parameter("tail_radius", 0.01, 0.3, 0.05, "radius of the last link", scale="log"),
    ),
    rules=(Rule("the tail must not be thicker than the head", thickens),),
    reward=REWARD,
    environment="robomore.envs.robots.swimmer:SwimmerEnvironment",
)
