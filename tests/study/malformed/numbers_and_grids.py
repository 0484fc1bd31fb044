"""Numbers, lists and grids that no study can have."""

from .row import toml, yaml

HEX = "0x" + "f" * 100_000


def value(label, key, written, *says, **more):
    """Return a study of a single value at a key of two parts, in TOML."""
    table, name = key.split(".")
    return toml(label, f"[{table}]\n{name} = {written}\n", key, *says, line=2, **more)


def value_yaml(label, key, written, *says, **more):
    """Return a study of a single value at a key of two parts, in YAML."""
    table, name = key.split(".")
    return yaml(label, f"{table}:\n  {name}: {written}\n", key, *says, line=2, **more)


def anchors_that_meet(label, anchors, more):
    """Return a study whose tendon has no length at the elbow where anchors of 100 mm meet."""
    arm = "".join(f'arm.{name} = "100 mm"\n' for name in anchors)
    return toml(f"anchors that meet {label}", arm + more, "arm", "L_c = 0")


NUMBERS = (
    # Units.
    value(
        "a mass for a length",
        "arm.b1",
        '"150 kg"',
        '"kg" is a mass',
        "expected a length",
        '"40 mm"',
    ),
    value(
        "an unknown unit",
        "arm.b1",
        '"150 furlong"',
        'unknown unit "furlong"',
        "known units: m, cm, mm",
    ),
    value(
        "knots for kilonewtons",
        "spring.stiffness",
        '"3 kn/m"',
        'unknown unit "kn/m"',
        'did you mean "kN/m"?',
    ),
    value("no unit in quotes", "arm.b1", '"150"', "has no unit", "150 m"),
    value("empty text", "arm.b1", '""', "not one number and one unit"),
    value(
        "two numbers and their errors", "arm.b1", '"150 mm +/- 2 mm +/- 1 mm"', "only one number"
    ),
    value("a decimal comma", "tendon.diameter", '"1,5 mm"', "the decimal sign is a point"),
    value("an expression", "tendon.length", '"2 * 4 m"', 'unknown unit "* 4 m"'),
    value(
        "a call", "tendon.length", "\"__import__('os').getcwd() m\"", "not one number and one unit"
    ),
    value("an exponent without end", "tendon.length", '"1e99999999999 m"', "tendon.length"),
    value("an exponent too large", "tendon.length", '"1e999 m"', "out of range"),
    # What is not a finite number.
    value("nan", "load.mass", "nan", "nan", "not a finite number"),
    value("a truth value", "load.mass", "true", "the truth value true is not a number"),
    value("a date", "load.mass", "2024-01-01", "2024-01-01 is not a number"),
    value(
        "a hexadecimal of 100000 digits", "load.mass", HEX, "120,412 digits", "not a finite number"
    ),
    toml("an integer of 5000 zeros", f"[load]\nmass = 1{'0' * 5000}\n", "more than 4300 digits"),
    value_yaml("a date", "load.mass", "2024-01-01", "is not a number"),
    value_yaml("the yes of old", "load.mass", "yes", "not one number and one unit"),
    value_yaml("nothing for a key", "load.mass", "", "has no value"),
    yaml(
        "an integer of 5000 nines",
        f"load: {{mass: {'9' * 5000}}}\n",
        "load.mass",
        "more than 4300 digits",
        line=1,
    ),
    # What cannot be.
    value("a negative mass", "load.mass", '"-1 kg"', "-1 kg is negative", "expected 0 to 10000 kg"),
    value("a tendon of no length", "tendon.length", '"0 m"', "impossible", "1e-06 to 100 m"),
    value("an arm of a kilometre", "arm.b1", '"1 km"', "1 km is out of range", "0.1 km"),
    anchors_that_meet("at an angle", ("a1", "b1", "a2", "b2"), 'motion.elbow_angle = "90 deg"\n'),
    anchors_that_meet(
        "in a case",
        ("a1", "b1", "a2"),
        '[[cases]]\nname = "a"\n[[cases]]\nname = "b"\narm.b2 = "100 mm"\n',
    ),
    anchors_that_meet("on an axis", ("a1", "b1", "a2"), 'arm.b2 = ["90 mm", "100 mm"]\n'),
    toml(
        "a friction beyond any sheath",
        "allow_implausible = true\nsheath = { friction = 9, bend_angle = '90 rad' }\n",
        "sheath.friction",
        "810",
    ),
    toml(
        "a friction beyond any sheath in a case",
        'allow_implausible = true\nsheath.bend_angle = "90 rad"\n'
        '[[cases]]\nname = "a"\nsheath.friction = 9\n',
        "friction",
        "810",
    ),
    # Lists.
    value("an empty list", "load.mass", "[]", "an empty list"),
    value("a list in a list", "load.mass", "[[1, 2], [3]]", "a list inside a list"),
    value(
        "a list with a bad unit",
        "load.mass",
        '["3 kg", "5 Kg"]',
        'unknown unit "Kg"',
        'did you mean "kg"?',
    ),
    value("a list that repeats itself", "load.mass", '["1 kg", "1000 g"]', "1000 g", "twice"),
    toml(
        "a list of smoothings",
        'sheath = { path = "r.csv", path_smoothing = [1] }\n',
        "path_smoothing",
        "one value",
    ),
)

IN_DEGREES = ('write "144 deg"', "may be degrees or radians")  # 144 rad is not possible
ANGLES = (
    value("a bare bend", "sheath.bend_angle", "144", *IN_DEGREES),
    value("a bare bend in text", "sheath.bend_angle", '"144"', 'write "144 deg"', "has no unit"),
    value(
        "a bare speed in text", "motion.speed", '"60"', '"60 deg/s" or "60 rad/s"', "has no unit"
    ),
    value("a bare angle in a list", "motion.elbow_angle", "[0, 144]", *IN_DEGREES),
    value(
        "a bare step",
        "motion.elbow_angle",
        "{ from = 0, to = '90 deg', step = 10 }",
        "step: 10 may be",
        '"10 deg"',
    ),
    value(
        "a bare tolerance",
        "sheath.bend_angle",
        "{ value = '90 deg', tolerance = 5 }",
        "tolerance",
        "not a share",
    ),
    value(
        "a bare deviation",
        "sheath.bend_angle",
        "{ mean = '90 deg', std = 5 }",
        "std: 5 may be",
        '"5 deg"',
    ),
)


def mass(label, written, *says):
    """Return a study of a load that is no number."""
    return value(label, "load.mass", written, *says)


UNCERTAIN = (
    mass(
        "a value without its tolerance", "{ value = 1 }", '"tolerance" is missing', "mean and std"
    ),
    mass("a mean without its deviation", "{ mean = 1 }", '"std" is missing'),
    mass("an uncertain grid", "{ value = 1, tolerance = '1 %', num = 3 }", 'unknown "num"'),
    mass("a tolerance of 200 %", "{ value = 1, tolerance = '200 %' }", "tolerance", "0 % to 100 %"),
    mass(
        "a tolerance beyond the value",
        "{ value = '1 kg', tolerance = '2 kg' }",
        "it reaches -1 kg",
        "impossible",
    ),
    mass(
        "a bare tolerance of a mass",
        "{ value = 1, tolerance = 0.1 }",
        "not a share of the value",
        '"10 %"',
    ),
    mass(
        "a tolerance of a length",
        "{ value = 1, tolerance = '1 mm' }",
        'tolerance: "mm" is a length',
    ),
    mass("a share of zero", "{ value = 0, tolerance = '10 %' }", '"10 %" of zero is zero'),
    mass("a deviation below zero", "{ mean = 1, std = -1 }", "std: -1 is negative"),
    value(
        "a tolerance down to nothing",
        "spring.stiffness",
        "{ value = 1, tolerance = '100 %' }",
        "it reaches 0 N/m",
    ),
    value(
        "an uncertain motion",
        "motion.elbow_angle",
        "{ mean = '9 deg', std = '1 deg' }",
        "cannot be uncertain here",
    ),
    toml(
        "an uncertain case",
        "[[cases]]\nname = 'a'\nload.mass = { mean = 1, std = 1 }\n",
        "load.mass",
        "one value",
        line=3,
    ),
)


def grid(label, table, *says):
    """Return a study of a load that is no grid."""
    return value(label, "load.mass", table, *says)


GRIDS = (
    grid(
        "a grid without num", '{ from = 0, to = 1, spacing = "log" }', '"num" is missing in a grid'
    ),
    grid(
        "an interval that goes down",
        '{ from = "1 kg", to = "20 g" }',
        "from is not below its to",
        '{ from = "20 g", to = "1 kg" }',
    ),
    grid(
        "a distribution that goes down", '"5 kg to 3 kg"', "goes from high to low", '"3 kg to 5 kg"'
    ),
    grid("a distribution without a unit", '"5 kg +/- 1"', 'std: "1" has no unit'),
    grid("a share for a deviation", '"5 kg +/- 10 %"', "may be a share"),
    grid("an empty grid", "{}", "is missing in a grid", "expected from, to, num"),
    grid(
        "a step that misses the end", "{ from = 0, to = 1, step = 0.3 }", "3.33333 steps", "num = 4"
    ),
    grid("a step of a length", '{ from = 0, to = 1, step = "1 m" }', 'step: "m" is a length'),
    grid(
        "a step that is no divisor and too small",
        "{ from = 0, to = 1, step = 3e-12 }",
        "is too many",
    ),
    grid(
        "a step of a factor",
        '{ from = 1, to = 10, step = 1, spacing = "log" }',
        "a step in a log grid",
    ),
    grid("a grid of 2.5", "{ from = 0, to = 1, num = 2.5 }", "num = 2.5 is not a count"),
    grid("a grid to the wrong unit", '{ from = "0 kg", to = "1 m", num = 3 }', '"m" is a length'),
    grid("a grid of equal ends", "{ from = 1, to = 1, num = 3 }", "equal from and to"),
    grid("a log grid from zero", '{ from = 0, to = 1, num = 3, spacing = "log" }', "above zero"),
    grid(
        "a spacing that is not",
        '{ from = 1, to = 2, num = 3, spacing = "logarithmic" }',
        '"linear" or "log"',
    ),
    toml(
        "a grid of 10^12",
        "[load]\nmass = { from = 0, to = 1, num = 1_000_000_000_000 }\n",
        "load.mass",
        "1,000,000,000,000 is too many",
        "10,000,000 values",
    ),
    grid("a grid of 10^7 + 1", "{ from = 0, to = 1, num = 10_000_001 }", "10,000,001 is too many"),
    yaml(
        "a grid of steps",
        "load:\n  mass: {from: 0, to: 1, stepp: 1}\n",
        "load.mass",
        'unknown "stepp"',
        line=2,
    ),
)
