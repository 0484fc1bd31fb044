"""Limits, goals and columns that no study can have."""

from .row import toml

MASSES = 'load.mass = ["3 kg", "5 kg"]\n'
LIMITS_THAT_NEED_A_SPEED = {
    "peak_motor_speed": "30 rpm",
    "peak_motor_power": "40 W",
}


def limit_without_speed(name, limit):
    """Return a study of a limit that needs a speed, and of no speed."""
    text = f"limits.{name} = '{limit}'\n"
    return toml(f"{name} without a speed", text, f"limits.{name}", "motion.speed", line=1)


DESIGNS = (
    toml(
        "a limit of no column",
        "limits.max_tensoin = '3 N'\n",
        "limits.max_tensoin",
        '"max_tension"',
        line=1,
    ),
    toml(
        "a limit that is uncertain",
        "limits.max_tension = '300 N +/- 10 N'\n",
        "limits.max_tension",
        "cannot be uncertain",
        line=1,
    ),
    toml(
        "a limit that is an interval",
        "limits.max_tension = { from = '300 N', to = '400 N' }\n",
        "limits.max_tension",
        '"num" is missing',
        line=1,
    ),
    toml(
        "a limit of a case that is an axis",
        "limits.max_tension = [300, 400]\n[[cases]]\nname = 'a'\nlimits.max_tension = 350\n",
        "cases.0.limits.max_tension",
        "is an axis",
    ),
    toml(
        "a limit of a case without what it needs",
        "[[cases]]\nname = 'a'\nlimits.peak_motor_power = '3 W'\n",
        "limits.peak_motor_power",
        "speed",
    ),
    toml(
        "a room for a spring of no length",
        "limits.min_spring_room = '0 mm'\n",
        "spring_room",
        "free_length",
    ),
    toml(
        "a room for a spring at the motor",
        "limits.min_spring_room = '0 mm'\nspring = { free_length = '70 mm', at = 'motor' }\n",
        "spring_room",
        "at the motor",
    ),
    toml(
        "a room for no spring",
        "limits.min_spring_room = '0 mm'\n"
        "spring = { free_length = '70 mm', stiffness = 'rigid' }\n",
        "spring_room",
        "has none",
    ),
    toml(
        "a pressure on no width",
        "limits.max_contact_pressure = '30 kPa'\n",
        "contact_pressure",
        "contact_width",
    ),
    toml(
        "a pressure on a width of one case",
        "limits.max_contact_pressure = '30 kPa'\n"
        "[[cases]]\nname = 'a'\narm.contact_width = '40 mm'\n"
        "[[cases]]\nname = 'b'\n",
        "limits.max_contact_pressure",
        "arm.contact_width",
        line=1,
    ),
    *(limit_without_speed(name, limit) for name, limit in LIMITS_THAT_NEED_A_SPEED.items()),
    toml("a speed of nothing", "motion.speed = '0 deg/s'\n", "motion.speed", "impossible", line=1),
    toml(
        "a speed in degrees",
        "motion.speed = '60 deg'\n",
        "motion.speed",
        "an angular speed",
        '"60 deg/s"',
        line=1,
    ),
    toml(
        "a condition that is a column",
        "design.conditions = 'load_mass'\n",
        "conditions",
        '"load.mass"',
        line=1,
    ),
    toml(
        "a condition that is no axis",
        "design.conditions = ['direction']\n",
        "conditions",
        "not an axis",
        line=1,
    ),
    toml(
        "a condition of pretension",
        "design.conditions = ['tendon.pretension']\n",
        "conditions",
        "solves for",
    ),
    toml(
        "a condition of nothing",
        "design.conditions = ['']\n",
        "design.conditions",
        "at least 1 character",
        line=1,
    ),
    toml(
        "a goal that is no column",
        "design.minimise = ['max_tensoin']\n",
        "design.minimise",
        '"max_tension"',
    ),
    toml(
        "a goal that is a condition",
        MASSES + "design.maximise = 'load_mass'\n",
        "design.maximise",
        line=2,
    ),
    toml(
        "a goal both ways",
        "design = { minimise = 'tolerance', maximise = 'tolerance' }\n",
        "maximise",
        "minimised",
    ),
    toml(
        "a place in no window",
        "design.pretension = 'most'\n",
        "design.pretension",
        '"least"',
        line=1,
    ),
    toml("2^62 draws", f"uncertainty.draws = {2**62}\n", "uncertainty.draws", "1,048,576", line=1),
    toml(
        "an exact number that is none",
        "uncertainty.exact = ['spring.stifness', 'joint sensor zero', 'arm']\n",
        "uncertainty.exact",
        'did you mean "spring.stiffness"?',
        line=1,
    ),
    toml(
        "an advice of words",
        "design.advice = 'yes'\n",
        "design.advice",
        "true or false",
        line=1,
    ),
    toml(
        "a state's column unknown",
        "output.states = ['statu']\n",
        "output.states",
        '"status"',
        line=1,
    ),
    toml(
        "a design's column of states",
        "output.states = ['margin']\n",
        "output.states",
        "of the states",
        line=1,
    ),
    toml(
        "a key as a column",
        "output.states = ['elbow_angle']\n",
        "output.states",
        "always written",
        line=1,
    ),
    toml(
        "columns of no table",
        "output = { tables = 'designs', states = ['status'] }\n",
        "output.states",
        "not written",
        line=1,
    ),
)
