"""How deep a part of any shape is in the ground: as deep as MuJoCo says."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from robomore.audit.ground import Ground
from robomore.tasks import get_task

SHAPES = {
    "sphere": 'type="sphere" size=".1"',
    "capsule": 'type="capsule" size=".05 .2"',
    "cylinder": 'type="cylinder" size=".05 .2"',
    "box": 'type="box" size=".05 .06 .2"',
    "ellipsoid": 'type="ellipsoid" size=".05 .06 .2"',
    "mesh": 'type="mesh" mesh="tetrahedron"',
}
FLOATS = """<mujoco><asset>
<mesh name="tetrahedron" vertex="0 0 0  .3 0 0  0 .2 0  0 0 .1  .02 .02 .02"/></asset><worldbody>
<geom type="plane" size="1 1 1"/><body><freejoint/><geom name="part" {shape}/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("turn", [(1, 0, 0, 0), (1, 0.3, -0.2, 0.5), (0.5, 0.5, 0.5, 0.5)])
def test_the_lowest_point_of_a_part(shape: str, turn: tuple[float, ...]) -> None:
    model = mujoco.MjModel.from_xml_string(FLOATS.format(shape=SHAPES[shape]))
    data, ground = mujoco.MjData(model), Ground(get_task("swimmer"), model)
    data.qpos[:] = [0.0, 0.0, -0.02, *np.array(turn) / np.linalg.norm(turn)]
    mujoco.mj_forward(model, data)
    ground.look(data)
    assert data.contact.dist.min() < 0
    assert ground.usual_depth == pytest.approx(-data.contact.dist.min(), abs=1e-6)
    size = model.geom("part").size
    assert ground.depths()["part"] == pytest.approx(ground.usual_depth / size[size > 0].min())
