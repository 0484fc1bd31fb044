"""Studies with two values of each limit that differ in what they allow."""

from tendon_cli.model.limits import LIMITS
from tests.answers import merged

SUIT = {
    "arm": {"contact_width": "40 mm"},
    "spring": {"stiffness": ["2 kN/m", "5 kN/m"], "free_length": "5 mm"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": {
        "speed": "60 deg/s",
        "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4},
    },
}
LOOSER_AND_TIGHTER = {
    "min_flexor_tension": ("35 N", "60 N"),
    "min_extensor_tension": ("2 N", "10 N"),
    "max_tension": ("240 N", "205 N"),
    "max_spring_extension": ("90 mm", "45 mm"),
    "peak_motor_torque": ("5.5 N m", "4.8 N m"),
    "max_contact_pressure": ("80 kPa", "40 kPa"),
    "min_spring_room": ("90 mm", "135 mm"),
    "min_elbow_stiffness": ("-2 N m/rad", "3 N m/rad"),
    "max_pretension": ("120 N", "70 N"),
    "min_spool_to_tendon": (20, 30),
    "peak_motor_speed": ("5.4 rad/s", "4 rad/s"),
    "peak_motor_power": ("16 W", "14 W"),
}
"""Two values of each limit, the looser first."""
assert LOOSER_AND_TIGHTER.keys() == LIMITS.keys()


def limited(limit, value, *contents):
    """Return the suit with one limit, a value or several."""
    return merged(SUIT, {"limits": {limit: value}}, *contents)
