"""What a URDF reader that we did not write makes of a robot, compared with its model."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import yourdfpy


def same_robot(model: mujoco.MjModel, file: Path) -> yourdfpy.URDF:
    """Compare masses, inertias, axes and limits of a model with a URDF file; returns that."""
    meshes = (file.parent / "meshes").exists()
    urdf = yourdfpy.URDF.load(
        str(file), load_meshes=meshes, filename_handler=lambda fname: str(file.parent / fname)
    )
    assert urdf.validate()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    for body in range(1, model.nbody):
        if not model.body_weldid[body]:
            continue
        link = urdf.link_map[model.body(body).name.replace(" ", "_")]
        pose = urdf.get_transform(link.name, "world")
        if model.body_mass[body]:
            inertia = link.inertial
            assert inertia.mass == model.body_mass[body]
            centre = pose @ inertia.origin @ [0, 0, 0, 1]
            np.testing.assert_allclose(centre[:3], data.xipos[body], atol=1e-9)
            turned = pose[:3, :3] @ inertia.inertia @ pose[:3, :3].T
            axes = data.ximat[body].reshape(3, 3)
            expected = axes @ np.diag(model.body_inertia[body]) @ axes.T
            np.testing.assert_allclose(turned, expected, atol=1e-9)
    for joint in range(model.njnt):
        if model.jnt_type[joint] in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            found = urdf.joint_map[model.joint(joint).name]
            pose = urdf.get_transform(found.child, "world")
            np.testing.assert_allclose(pose[:3, :3] @ found.axis, data.xaxis[joint], atol=1e-9)
            np.testing.assert_allclose(pose[:3, 3], data.xanchor[joint], atol=1e-9)
            limited = bool(model.jnt_limited[joint])
            assert (found.limit.lower is not None and abs(found.limit.lower) < 1e5) == limited
    return urdf
