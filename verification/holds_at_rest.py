"""Do the keyframes of exported models hold? `python -m verification.holds_at_rest FILE.xml ...`.

Each keyframe of `tendon export --to mujoco` is a state of rest without friction. Prints the largest
acceleration of any joint in units of what its weight and torque would give, and ends with 1 if one
is larger than rounding.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np

TOLERANCE = 1e-9
"""Largest force that is left at a joint, as a share of the forces that balance there."""


def main(files: list[str]) -> int:
    """Load models, check their keyframes, and return the exit code."""
    worst = 0.0
    keyframes = 0
    for file in files:
        model = mujoco.MjModel.from_xml_path(str(Path(file)))
        data = mujoco.MjData(model)
        keyframes += model.nkey
        for key in range(model.nkey):
            mujoco.mj_resetDataKeyframe(model, data, key)
            mujoco.mj_forward(model, data)
            left = data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias
            forces = (data.qfrc_passive, data.qfrc_actuator, data.qfrc_bias)
            scale = max(float(np.max(np.abs(force))) for force in forces)
            worst = max(worst, float(np.max(np.abs(left))) / scale)
    sys.stdout.write(f"{keyframes} keyframes, largest force left {worst:.1e} of those that act\n")
    return 0 if keyframes and worst < TOLERANCE else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
