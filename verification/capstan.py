"""A rope of beads dragged over a drum in MuJoCo, with a load cell at each end.

MuJoCo's tendons do not rub. Its contacts do: the rope is a chain of point masses, each pressed on
the drum by the links to its neighbours and held back by the engine's Coulomb contact. Nothing here
knows the capstan equation. The motor moves to and fro; the load is a spring, so that the force
varies. Cells and spring pull only beyond their natural length: before the rope is taut, and after,
both cells read zero.
"""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

TURN = np.radians(144.0)
"""Angle by which the rope turns over the drum, rad."""
_BEADS = 48
"""Beads on the drum, 3 deg each: a polygon's limit 2 n artanh(μ tan(φ/2n)) is then within 0.03 % of
μφ."""
_RADIUS = 0.05  # m, of the rope's path over the drum
_BEAD = 0.001  # m, radius of a bead
_FREE = 0.3  # m of each cell's strand, along the drum's tangent
_SLACK = 0.001  # m that the motor moves before its cell pulls
_CELL = 20e3  # N/m, stiffness of the cell at the motor
_SPRING = 4e3  # N/m, stiffness of the load
_LOW = 0.004  # m, where the motor turns round
_HIGH = 0.014  # m, where the motor turns round
_SPEED = 0.005  # m/s: dragging the beads against their damping takes 0.0015 N
_STEP = 0.0005  # s, of the simulation
_REPORT = 0.02  # s, between readings

# A constraint of impedance 0.97 gives way a little: the rope stretches. Nearly rigid, 0.99
# and more, it chatters on the drum at large friction, and rubs less than it should.
_MJCF = """
<mujoco>
  <option gravity="0 0 0" timestep="{step!r}" cone="elliptic" impratio="10"
    integrator="implicitfast" iterations="50" tolerance="1e-12"/>
  <default>
    <geom condim="3" friction="{friction!r} 0 0" solref="{soft!r} 1" solimp="0.97 0.97 0.0001"/>
    <joint type="slide" damping="0.005"/>
    <equality solref="{soft!r} 1" solimp="0.97 0.97 0.0001"/>
  </default>
  <worldbody>
    <geom type="cylinder" size="{drum!r} 0.01" zaxis="0 1 0" contype="0" conaffinity="1"/>
    {beads}
    <body name="motor" mocap="true" pos="{motor}"><site name="motor"/></body>
    <site name="load" pos="{load}"/>
  </worldbody>
  <tendon>
    <spatial name="motor cell" stiffness="{cell!r}" springlength="0 {cell_length!r}">
      <site site="motor"/><site site="0"/>
    </spatial>
    <spatial name="load cell" stiffness="{spring!r}" springlength="0 {spring_length!r}">
      <site site="{last}"/><site site="load"/>
    </spatial>
    {links}
  </tendon>
  <equality>{holds}</equality>
</mujoco>
"""
_BODY = """<body pos="{0}"><joint axis="1 0 0"/><joint axis="0 0 1"/><site name="{1}"/>
      <geom type="sphere" size="{2!r}" mass="0.01" contype="1" conaffinity="0"/></body>"""


def readings(friction: float, *, cycles: int = 5) -> tuple[Array, Array, Array]:
    """Drag the rope from slack, to and fro, to slack.

    Args:
        friction: Coefficient of the contacts.
        cycles: Number of strokes to and fro.

    Returns:
        Time (s), and the forces at the motor and at the load (N, means over 20 ms).
    """
    model = mujoco.MjModel.from_xml_string(_mjcf(friction))
    data = mujoco.MjData(model)
    start = data.mocap_pos[0].copy()
    travel = np.array([0.0, _HIGH, *[_LOW, _HIGH] * cycles, -_SLACK])
    turns = 0.5 + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(travel))) / _SPEED])
    per_reading = round(_REPORT / _STEP)
    count = int((turns[-1] + 0.5) / _REPORT)
    forces = np.zeros((count, 2))
    for step in range(count * per_reading):
        data.mocap_pos[0, 2] = start[2] - np.interp(step * _STEP, turns, travel)
        mujoco.mj_step(model, data)
        stretch = data.ten_length[:2] - (_FREE + _SLACK, _FREE)
        forces[step // per_reading] += np.maximum(0.0, stretch * (_CELL, _SPRING)) / per_reading
    return _REPORT * np.arange(count), forces[:, 0], forces[:, 1]


def _mjcf(friction: float) -> str:
    """Return the model of the rope at rest, just taut.

    Three beads lie before the drum, and eight behind it to be pulled on.
    """
    along = np.arange(-3.5, _BEADS + 8.0) * _RADIUS * TURN / _BEADS
    last = len(along) - 1
    beads = [_BODY.format(_place(s), i, _BEAD) for i, s in enumerate(along)]
    links = [
        f'<spatial name="link {i}"><site site="{i}"/><site site="{i + 1}"/></spatial>'
        for i in range(last)
    ]
    holds = [f'<tendon tendon1="link {i}"/>' for i in range(last)]
    return _MJCF.format(
        friction=float(friction),
        step=_STEP,
        soft=2.0 * _STEP,
        drum=_RADIUS - _BEAD,
        beads="\n    ".join(beads),
        motor=_place(along[0] - _FREE),
        load=_place(along[-1] + _FREE),
        cell=_CELL,
        cell_length=_FREE + _SLACK,
        spring=_SPRING,
        spring_length=_FREE,
        last=last,
        links="\n    ".join(links),
        holds="".join(holds),
    )


def _place(along: float) -> str:
    """Return the position of the rope, as MuJoCo reads it.

    `along` is the length (m) along its path from the point on the motor's side where it meets the
    drum.
    """
    angle = np.clip(along / _RADIUS, 0.0, TURN)
    beyond = along - angle * _RADIUS
    x = _RADIUS * np.cos(angle) - beyond * np.sin(angle)
    z = _RADIUS * np.sin(angle) + beyond * np.cos(angle)
    return f"{float(x)!r} 0 {float(z)!r}"
