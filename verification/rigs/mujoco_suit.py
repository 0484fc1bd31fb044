"""A suit in MuJoCo: another engine, and driven the other way about.

The motor is a servo that turns the spool; forearm and load are bodies that swing under gravity,
and the joint's angle is what comes out. Each cable is a row of beads on a rail, tied by tendons
that pull and cannot push; dry friction on each bead is set at every step to what a bend of μφ/n
takes of the tensions on its sides. The flexor's last tendon runs through space from the sheath's
end to the forearm, so that its length and lever are the engine's own.

MuJoCo is no dependency of tendon: `verification/requirements.txt` names its version. The logs are
kept in `mujoco_suit.npz`; `python -m verification.rigs.mujoco_suit` makes them anew, by a Python
that has MuJoCo.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .elastic_links import History, Motion, simulate
from .gripped_cables import Array
from .suit_logs import CYCLE, RATE, LogFault, Session, SuitLog, rig_of, session_of, write_log

BEADS = 8
"""Beads of each cable."""

BEAD_MASS = 0.06
"""Mass of a bead, kg; next to nothing against tensions that change within seconds."""

ROTOR = 1e-3
"""Inertia of rotor and spool, kg m²; 0.02 would take 0.05 N m of the motor at these speeds."""

STEP = 2e-4
"""Step of the engine, s."""

CYCLES = 4
"""Cycles of a log that are kept."""

LEAD = 4.0
"""Time before them, s, in which the spool brings the joint to where the motion begins."""

RAIL = 1.0
"""Length of a sheath's rail above the upper arm's anchor, m; any."""

GAIN = 1.5
"""Spool's speed per error of the joint's angle while it is brought there, 1/s."""

SERVO = 4000.0
"""Stiffness of the motor's servo, N m/rad."""

DAMPING = 0.1
"""Damping of the joint, N m s/rad."""

STEADYING = 5.0
"""Damping while the joint is brought to where the motion begins, N m s/rad."""

SEEDS = (101, 102, 103)
"""Seeds of the suits that are kept."""

CACHE = Path(__file__).with_name("mujoco_suit.npz")
"""Logs of all loads of these suits, without noise."""

CHANNELS = ("angle", "spool_angle", "motor_torque", "flexor_motor", "flexor_elbow")
"""Channels of each log that are kept."""


def model_text(suit: Mapping[str, Any], load: float) -> str:
    """Return the MJCF of a suit: SI units, the upper arm hanging from the origin's elbow."""
    arm = suit["arm"]
    joint = suit["joint"]
    spool = suit["spool"]["flexor_radius"]
    extensor_spool = spool * suit["spool"]["ratio"]
    gap = RAIL / (BEADS + 1)
    beads = []
    ties = []
    for side, forward in (("f", arm["a1"]), ("e", -arm["elbow_radius"])):
        for place in range(BEADS):
            height = arm["b1"] + RAIL - (place + 1) * gap
            beads.append(
                f'<body name="{side}{place}" pos="{forward} 0 {height}">'
                f'<joint name="{side}{place}" type="slide" axis="0 0 1"/>'
                f'<geom type="sphere" size="0.003" mass="{BEAD_MASS}" contype="0" conaffinity="0"/>'
                f'<site name="{side}{place}"/></body>'
            )
        winds = spool if side == "f" else -extensor_spool
        ties.append(
            f'<fixed name="{side}0"><joint joint="spool" coef="{winds}"/>'
            f'<joint joint="{side}0" coef="-1"/></fixed>'
        )
        ties.extend(
            f'<fixed name="{side}{place}"><joint joint="{side}{place - 1}" coef="1"/>'
            f'<joint joint="{side}{place}" coef="-1"/></fixed>'
            for place in range(1, BEADS)
        )
    last = BEADS - 1
    ties.append(
        f'<spatial name="f{BEADS}"><site site="f{last}"/><site site="upper_arm"/>'
        '<site site="forearm"/></spatial>'
    )
    ties.append(
        f'<fixed name="e{BEADS}"><joint joint="e{last}" coef="1"/>'
        f'<joint joint="elbow" coef="{arm["elbow_radius"]}"/></fixed>'
    )
    held_load = (
        f'<geom type="sphere" size="0.01" pos="0 0 {-arm["load_distance"]}" mass="{load}" '
        'contype="0" conaffinity="0"/>'
        if load
        else ""
    )
    return f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{STEP}" integrator="implicitfast" gravity="0 0 -9.81" cone="elliptic"/>
  <worldbody>
    <site name="upper_arm" pos="{arm["a1"]} 0 {arm["b1"]}"/>
    <body name="forearm">
      <joint name="elbow" type="hinge" axis="0 -1 0" stiffness="{joint["stiffness"]}"
             springref="{joint["rest_angle"]}" damping="{DAMPING}"/>
      <geom type="sphere" size="0.01" pos="0 0 {-arm["forearm_com"]}"
            mass="{arm["forearm_mass"]}" contype="0" conaffinity="0"/>
      {held_load}
      <site name="forearm" pos="{arm["a2"]} 0 {-arm["b2"]}"/>
    </body>
    <body name="spool" pos="0 0 2" gravcomp="1">
      <joint name="spool" type="hinge" axis="0 1 0" armature="{ROTOR}"/>
      <geom type="sphere" size="0.01" mass="0.001" contype="0" conaffinity="0"/>
    </body>
    {"".join(beads).replace("<body ", '<body gravcomp="1" ')}
  </worldbody>
  <tendon>{"".join(ties)}</tendon>
  <actuator>
    <position name="motor" joint="spool" kp="{SERVO}" kv="{0.02 * SERVO}"/>
  </actuator>
</mujoco>"""


def link_compliances(suit: Mapping[str, Any]) -> Array:
    """Return the compliance of each link of one cable, motor's end first (beads + 1,), m/N."""
    tendon = suit["tendon"]
    area = np.pi * tendon["diameter"] ** 2 / 4.0
    links = np.full(BEADS + 1, tendon["length"] / (area * tendon["youngs_modulus"]) / BEADS)
    links[[0, -1]] *= 0.5
    links[-1] += 1.0 / suit["spring"]["stiffness"] + 1.0 / suit["anchor"]["stiffness"]
    return links


def spool_course(session: Session, log: int) -> Array:
    """Return how the servo turns the spool, from 0 on, at a log's rows, rad.

    It is how the rig of elastic links would turn it for the session's angles: only so that the
    joint moves about so. The joint's angle that is logged is the engine's own.
    """
    motion = Motion(
        time=session.time, angle=session.angles[log], acceleration=np.zeros(len(session.time))
    )
    (led,) = simulate([rig_of(session, session.loads[log])], [motion], nodes=BEADS)
    smooth = np.hanning(15) / np.hanning(15).sum()
    padded = np.pad(led.spool_angle, 7, mode="edge")
    return np.convolve(padded, smooth, mode="valid") - led.spool_angle[0]


@dataclass(frozen=True)
class Engine:
    """A model of MuJoCo with the cables' numbers.

    Attributes:
        model: Compiled model.
        data: Its state.
        links: Indices of the tendons that are links, the flexor's first, motor's end first.
        beads: Indices of the beads' degrees of freedom, in the same order.
        resting: Lengths of the links without tension (links,), m.
        compliance: Of each link (links,), m/N.
        grip: Friction of a bead over the sum of the tensions on its sides.
    """

    model: Any
    data: Any
    links: NDArray[np.intp]
    beads: NDArray[np.intp]
    resting: Array
    compliance: Array
    grip: float

    def tensions(self) -> Array:
        """Return the tensions of all links (2, beads + 1), N."""
        stretch = self.data.ten_length[self.links] - self.resting
        return (np.maximum(stretch, 0.0) / self.compliance).reshape(2, -1)

    def step(self, spool_angle: float, damping: float) -> None:
        """Set the beads' friction and go one step on, the servo led to a spool angle."""
        import mujoco

        sides = self.tensions()
        resists = self.grip * (sides[:, 1:] + sides[:, :-1])
        self.model.dof_frictionloss[self.beads] = resists.ravel()
        self.model.dof_damping[self.model.joint("elbow").dofadr[0]] = damping
        self.data.ctrl[0] = spool_angle
        mujoco.mj_step(self.model, self.data)


def start_engine(session: Session, log: int) -> Engine:
    """Compile the model of one log, with all links at the pretension."""
    import mujoco

    suit = session.suit
    model = mujoco.MjModel.from_xml_string(model_text(suit, session.loads[log]))
    one = link_compliances(suit)
    compliance = np.concatenate([one, one])
    names = [f"{side}{place}" for side in "fe" for place in range(BEADS + 1)]
    links = np.array([model.tendon(name).id for name in names])
    joints = [f"{side}{place}" for side in "fe" for place in range(BEADS)]
    beads = np.array([model.joint(name).dofadr[0] for name in joints])

    resting = -compliance * suit["tendon"]["pretension"]
    straight = suit["arm"]["b1"] + suit["arm"]["b2"]
    resting[BEADS] += RAIL / (BEADS + 1) + straight
    model.tendon_lengthspring[links, 0] = -10.0
    model.tendon_lengthspring[links, 1] = resting
    model.tendon_stiffness[links] = 1.0 / compliance
    model.tendon_damping[links] = 40.0
    model.tendon_damping[links[[BEADS, -1]]] = 1.0
    model.dof_solref[beads] = (2.0 * STEP, 1.0)
    model.dof_solimp[beads] = (0.99, 0.999, 1e-4, 0.5, 2.0)
    bend = suit["sheath"]["friction"] * suit["sheath"]["bend_angle"] / BEADS
    grip = float(np.tanh(0.5 * bend))
    data = mujoco.MjData(model)
    return Engine(model, data, links, beads, resting, compliance, grip)


def run_log(session: Session, log: int) -> dict[str, Array]:
    """Run one log and return its channels at the rows' instants."""
    engine = start_engine(session, log)
    elbow = engine.model.joint("elbow").qposadr[0]
    spool = engine.model.joint("spool").qposadr[0]
    rows = round(CYCLES * CYCLE * RATE)
    kept = {name: np.zeros(rows) for name in CHANNELS}
    every = round(1.0 / (RATE * STEP))
    lead = round(LEAD / STEP)
    course = spool_course(session, log)
    instants = session.time
    start = float(session.angles[log].min())
    begin = 0.0
    for count in range(lead + rows * every):
        time = count * STEP
        angle = engine.data.qpos[elbow]
        if time < LEAD - 1.0:
            begin += GAIN * STEP * (start - angle)
        aim = begin + np.interp(time - LEAD, instants, course)
        engine.step(aim, np.interp(time, [LEAD - 1.0, LEAD], [STEADYING, DAMPING]))
        row, rest = divmod(count - lead, every)
        if row >= 0 and rest == 0:
            tension = engine.tensions()
            kept["angle"][row] = engine.data.qpos[elbow]
            kept["spool_angle"][row] = engine.data.qpos[spool]
            kept["motor_torque"][row] = engine.data.actuator_force[0]
            kept["flexor_motor"][row] = tension[0, 0]
            kept["flexor_elbow"][row] = tension[0, -1]
    return kept


def make_mujoco_cache(path: Path = CACHE) -> None:
    """Run all logs and write the file."""
    arrays: dict[str, NDArray[np.float32]] = {}
    for seed in SEEDS:
        session = session_of(seed, "none")
        for log in range(len(session.loads)):
            for name, values in run_log(session, log).items():
                arrays[f"{name}_{seed}_{log}"] = values.astype(np.float32)
    np.savez_compressed(path, **arrays)


def kept_history(seed: int, log: int) -> History:
    """Return what is kept of one log; all other channels are zero."""
    with np.load(CACHE) as file:
        kept = {name: file[f"{name}_{seed}_{log}"].astype(float) for name in CHANNELS}
    rows = len(kept["angle"])
    nothing = dict.fromkeys(History.__dataclass_fields__, np.zeros(rows))
    return History(**{**nothing, **kept, "time": np.arange(rows) / RATE})


def mujoco_log(seed: int = SEEDS[0], with_tension: bool = False) -> SuitLog:
    """Return study, logs and truth of a suit of MuJoCo, with noise as of other suits.

    Its bodies have inertia, which at these speeds takes up to 0.3 N m, and its joint is damped.
    """
    session = session_of(seed, "none")
    if with_tension:
        session = replace(session, tensions=("flexor_tension_proximal",))
    histories = [kept_history(seed, log) for log in range(len(session.loads))]
    return write_log(session, histories, seed, "MuJoCo", LogFault())


if __name__ == "__main__":
    make_mujoco_cache()
