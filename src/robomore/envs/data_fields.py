"""Which fields of MuJoCo's data a reward may read, and which of them are computed on request.

A field is named here if it has, after a control step, the value that MuJoCo alone would give it,
and the same value in a training that was interrupted. All others are refused: working memory,
counters of the process, and results that only other functions of MuJoCo fill in.
"""

from __future__ import annotations

import mujoco

REQUESTS = (mujoco.mj_rnePostConstraint, mujoco.mj_subtreeVel)
"""Functions that compute what a step leaves out; a reward that reads such a field requests one."""

ON_REQUEST = {
    **dict.fromkeys(("cacc", "cfrc_int", "cfrc_ext"), 0),
    **dict.fromkeys(("subtree_linvel", "subtree_angmom"), 1),
}
"""Fields that a step leaves out, each with the place of its function in `REQUESTS`."""

_PLAIN = """
    time qpos qvel act act_dot ctrl qacc qacc_smooth xfrc_applied eq_active mocap_pos mocap_quat
    qfrc_applied qfrc_actuator qfrc_adhesion qfrc_bias qfrc_constraint qfrc_damper qfrc_fluid
    qfrc_gravcomp qfrc_passive qfrc_smooth qfrc_spring userdata sensordata plugin_state
    xpos xquat xmat xipos ximat xanchor xaxis geom_xpos geom_xmat site_xpos site_xmat
    cam_xpos cam_xmat light_xpos light_xdir subtree_com cdof cdof_dot cinert crb cvel
    ten_length ten_velocity ten_J ten_wrapadr ten_wrapnum wrap_obj wrap_xpos
    actuator_length actuator_velocity actuator_force actuator_moment
    moment_colind moment_rowadr moment_rownnz flexvert_xpos flexedge_length flexedge_velocity
    M contact ncon ne nf nl nefc efc_type efc_id efc_pos efc_margin efc_frictionloss efc_D efc_R
    efc_vel efc_aref efc_force efc_state
    actuator body cam camera geom jnt joint light sensor site ten tendon model
"""

READABLE = frozenset(ON_REQUEST) | frozenset(_PLAIN.split())
"""Fields that can be read, with the methods that find parts by name."""

REFUSED = frozenset(name for name in dir(mujoco.MjData) if name[0] != "_") - READABLE

_REASONS = {
    "energy": "it is not computed in training; compute it from qpos, qvel and the masses",
    "qfrc_inverse": "inverse dynamics is not computed in training; read qfrc_actuator, "
    "qfrc_passive or qfrc_constraint",
}


def refusal(name: str) -> str:
    """Return why a field cannot be read, in words for the author of a reward."""
    reason = _REASONS.get(
        name, "it is working memory of MuJoCo, whose content says nothing about the robot"
    )
    return f"a reward cannot read `{name}` of the simulation: {reason}"
