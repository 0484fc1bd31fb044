"""Valid studies by chance: every section and key of a study, with numbers of a real suit.

A study is small, some choices under some conditions at some angles, so that it is answered within a
second. It is valid by itself nearly always; what only many keys together forbid may be refused.
"""

import math
import random

NUMBERS = {
    "arm.a1": (20, 80, "mm"),
    "arm.b1": (100, 250, "mm"),
    "arm.a2": (10, 60, "mm"),
    "arm.b2": (100, 250, "mm"),
    "arm.elbow_radius": (20, 70, "mm"),
    "arm.forearm_mass": (0.8, 3, "kg"),
    "arm.forearm_com": (100, 250, "mm"),
    "arm.load_distance": (200, 400, "mm"),
    "arm.upper_arm_angle": (-30, 90, "deg"),
    "arm.contact_from": (-10, 60, "deg"),
    "arm.contact_width": (10, 80, "mm"),
    "arm.contact_radius": (20, 80, "mm"),
    "sheath.friction": (0, 0.3, ""),
    "sheath.bend_angle": (0, 720, "deg"),
    "tendon.length": (0.3, 3, "m"),
    "tendon.diameter": (0.5, 3, "mm"),
    "tendon.youngs_modulus": (1, 200, "GPa"),
    "tendon.breaking_force": (200, 5000, "N"),
    "tendon.pretension": (5, 400, "N"),
    "spring.stiffness": (0.5, 50, "kN/m"),
    "spring.free_length": (20, 150, "mm"),
    "anchor.stiffness": (2, 100, "kN/m"),
    "joint.stiffness": (0, 5, "N m/rad"),
    "joint.rest_angle": (0, 90, "deg"),
    "spool.flexor_radius": (10, 60, "mm"),
    "spool.ratio": (0.4, 1.5, ""),
    "load.mass": (0, 10, "kg"),
    "load.scale": (-1, 2, ""),
    "setting.angle": (0, 60, "deg"),
    "setting.upper_arm_angle": (-20, 60, "deg"),
    "setting.load": (0, 2, "kg"),
}
"""Lowest and highest value of each number, and its unit."""
GIVEN_TABLES = ("load", "joint", "anchor", "setting", "arm")
"""Tables whose axes are conditions unless a study says otherwise."""
ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
LIMITS = {
    "min_flexor_tension": (0, 20, "N"),
    "min_extensor_tension": (0, 20, "N"),
    "max_tension": (100, 2000, "N"),
    "max_spring_extension": (10, 150, "mm"),
    "peak_motor_torque": (2, 60, "N m"),
    "max_contact_pressure": (10, 1000, "kPa"),
    "min_spring_room": (-50, 50, "mm"),
    "min_elbow_stiffness": (-5, 30, "N m/rad"),
    "max_pretension": (20, 800, "N"),
    "min_spool_to_tendon": (5, 40, ""),
    "peak_motor_speed": (1, 40, "rad/s"),
    "peak_motor_power": (1, 100, "W"),
}
"""Lowest and highest value of each limit, and its unit."""
OF_A_SPEED = [*LIMITS][10:]
GOALS = (
    "tolerance",
    "served_at",
    "pretension",
    "pretension_from",
    "pretension_to",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
)
GOALS_OF_A_MOTION = ("peak_motor_power", "motor_work_in", "friction_loss", "spool_travel")
STATE_COLUMNS = ("status", "motor_torque", "flexor_tension_distal", "elbow_stiffness")
FILES = {
    "route.csv": "x_mm,y_mm,z_mm\n0,0,0\n100,0,0\n200,10,0\n250,80,10\n260,160,20\n300,240,10\n",
    "people.csv": "name,sex,weight (kg),stature (cm),weighting\n"
    "Ada,female,62.5,168,1\nBo,male,90,181.5,2\n",
    "person.csv": "name,sex,weight (kg),stature (cm)\nAda,female,62.5,168\n",
    "friction.toml": "[friction]\ncoefficient = 0.074\nstandard_error = 0.002\n",
    "base.toml": '# A base\ntitle = "A base"\n[arm]\nforearm_mass = "1.4 kg"\n'
    '[limits]\nmax_tension = "900 N"\n[motion]\nspeed = "40 deg/s"\n',
    "springs.csv": "name,spring.stiffness (kN/m),limits.max_spring_extension (mm),price (EUR),by\n"
    'Elbow S5,5,90,"12,5",elbow inc\n"<a href=x>S8</a>",8,60,on request,=cmd|x\n+S10,10,,21,@x\n',
    "spools.csv": "# Spools\nname;spool.flexor_radius (mm);spool.ratio;price (EUR);made\n"
    "a;30;0,6;9;yes\nb;24;0,8;;no\n",
    "postures.csv": "name,load.mass,arm.upper_arm_angle (deg)\nup,1 kg,-20\nfront,0.5 kg,60\n",
}
"""Files that studies name."""
ROW_FILES = {
    "springs.csv": ["spring.stiffness", "limits.max_spring_extension"],
    "spools.csv": ["spool.flexor_radius", "spool.ratio"],
    "postures.csv": ["load.mass", "arm.upper_arm_angle"],
}
"""Keys that the rows of each file set."""
TABLE_NAMES = ("part", "spring", "robe", "conditions", "designs", "states", "persons")
"""Names that tables may have, some of them those of files."""
ROW_NAMES = ("a", "Elbow S5", "=1+1", "<br>", "x, y", "Größe 2", "elbow_angle", "1")
"""Names that rows may have."""


def said(number, unit):
    """Return a number with its unit, if it has one."""
    return f"{number:.6g} {unit}".strip()


class Maker:
    """Maker of studies, one for each seed."""

    def __init__(self, seed):
        self.rng = random.Random(seed)  # noqa: S311 - a repeatable sample
        self.room = {"choice": 6, "condition": 4}
        self.intervals = 1
        self.is_uncertain = False

    def happens(self, chance):
        """Return True with a probability."""
        return self.rng.random() < chance

    def study(self):
        """Return a study as a dictionary of keys."""
        joint = self.joint()
        setting = self.setting()
        study = {
            "name": "random",
            "title": "A study by chance",
            "arm": self.table("arm", 0.2, ANCHORS if "excursion" in joint else ()),
            "sheath": self.sheath(),
            "tendon": self.tendon(setting),
            "spring": self.spring(),
            "anchor": self.of_sides("anchor", 0.2),
            "joint": joint,
            "spool": self.table("spool", 0.4),
            "load": self.load(),
            "setting": setting,
            "motion": self.motion(),
            "model": self.model(),
            "output": self.output(),
        }
        if self.happens(0.9):  # by default an answer draws 256 suits
            study["uncertainty"] = self.uncertainty()
        if self.happens(0.12):
            study["people"] = self.people(study)
        free = self.free_keys(study)
        if self.happens(0.2):
            study["cases"] = self.cases(free)
        study["limits"] = self.limits(study)
        if self.happens(0.4):
            study["table"] = self.tables(study, free)
        if self.happens(0.15):
            study["extends"] = "base.toml"
        study["design"] = self.goals(study)
        if self.happens(0.1):
            study["figure"] = [{"name": "a-figure", "quantity": ["required_pretension"]}]
        if self.happens(0.05):
            study["allow_implausible"] = True
        kept = {key: value for key, value in study.items() if value != {}}
        names = [name for name in kept if isinstance(kept[name], dict)]
        self.rng.shuffle(names)
        plain = {name: value for name, value in kept.items() if name not in names}
        return plain | {name: kept[name] for name in names}

    # --- Numbers ----------------------------------------------------------------------------------

    def number(self, key):
        """Return a number in one of the forms that a study has for it."""
        kind = "condition" if key.partition(".")[0] in GIVEN_TABLES else "choice"
        forms = [self.uncertain] * 2
        if self.intervals and key != "tendon.pretension":
            forms.append(self.interval)
        if self.room[kind] > 1:
            forms += [*[self.listed] * 3, self.grid]
        forms += [self.single] * len(forms)
        value, length = self.rng.choice(forms)(*NUMBERS[key])
        if length > 1:
            self.room[kind] //= length
        return value

    def value(self, low, high):
        """Return a number between two, its ends among them."""
        return self.rng.choice([low, high, *[self.rng.uniform(low, high)] * 8])

    def measure(self, low, high, unit):
        """Return a text of a number and a unit."""
        return said(self.value(low, high), unit)

    def single(self, low, high, unit):
        """Return one value."""
        return self.measure(low, high, unit), 1

    def listed(self, low, high, unit):
        """Return a list of one to three values."""
        length = self.rng.choice([1, 2, 2, 3])
        values = {self.measure(low, high, unit) for _ in range(length)}
        return sorted(values), len(values)

    def ends(self, low, high):
        """Return two numbers, the first the smaller one."""
        first = low + (high - low) * self.rng.uniform(0, 0.5)
        second = low + (high - low) * self.rng.uniform(0.6, 1)
        return float(f"{first:.4g}"), float(f"{second:.4g}")

    def grid(self, low, high, unit):
        """Return a range of two or three values, by their number or step, even or by a factor."""
        first, second = self.ends(low, high)
        grid = {"from": said(first, unit), "to": said(second, unit)}
        spacings = ["num", "step"]
        if first > 0:
            spacings.append("log")
        spacing = self.rng.choice(spacings)
        if spacing == "step":
            return grid | {"step": said(second - first, unit)}, 2
        length = self.rng.choice([2, 3])
        if spacing == "log":
            grid["spacing"] = "log"
        return grid | {"num": length}, length

    def interval(self, low, high, unit):
        """Return an interval, of which all values are meant."""
        self.intervals -= 1
        first, second = self.ends(low, high)
        return {"from": said(first, unit), "to": said(second, unit)}, 2

    def uncertain(self, low, high, unit):
        """Return a distribution about the middle."""
        self.is_uncertain = True
        middle = low + (high - low) * self.rng.uniform(0.4, 0.6)
        spread = (high - low) * self.rng.uniform(0.02, 0.1)
        about = said(middle, unit)
        wide = said(spread, unit)
        forms = [
            {"value": about, "tolerance": "5 %"},
            {"value": about, "tolerance": wide if unit else "3 %"},
            {"mean": about, "std": wide},
            f"{about} +/- {wide}",
            f"{said(middle - spread, unit)} to {said(middle + spread, unit)}",
        ]
        if abs(middle) < 1e-9:
            forms = forms[1:]
        return self.rng.choice(forms), 1

    def table(self, name, chance, without=()):
        """Return the numbers of a table, each with a probability."""
        keys = [key for key in NUMBERS if key.partition(".")[0] == name]
        self.rng.shuffle(keys)
        table = {}
        for key in keys:
            column = key.partition(".")[2]
            if column not in without and self.happens(chance):
                table[column] = self.number(key)
        return table

    def of_sides(self, name, chance, without=()):
        """Return the numbers of a table with those of one side or of both."""
        table = self.table(name, chance, without)
        for side in ("flexor", "extensor"):
            if self.happens(chance / 2):
                inner = self.table(name, 0.5, without)
                if inner:
                    table[side] = inner
        return table

    # --- Curves -----------------------------------------------------------------------------------

    def curve_angles(self, fewest=3):
        """Return angles that reach beyond every motion."""
        count = self.rng.randint(fewest, 8)
        angles = [-45 + 225 * place / (count - 1) for place in range(count)]
        return [f"{angle:.6g} deg" for angle in angles]

    def bend(self):
        """Return a bend that follows the joint."""
        angles = self.curve_angles(2)
        start = self.rng.uniform(30, 360)
        rise = self.rng.uniform(-20, 60)
        bends = [f"{start + rise * place:.4g} deg" for place in range(len(angles))]
        if rise < 0:
            bends = [
                f"{start + rise * place / len(angles):.4g} deg" for place in range(len(angles))
            ]
        return {"angle": angles, "bend": bends}

    def torque(self):
        """Return a torque over the angle."""
        angles = self.curve_angles()
        values = [f"{self.rng.uniform(-2, 4):.3g} N m" for _ in angles]
        return {"angle": angles, "torque": values}

    def excursion(self):
        """Return travels of both tendons, which rise with the angle."""
        angles = self.curve_angles()
        curve = {"angle": angles}
        for side in ("flexor", "extensor"):
            radius = self.rng.uniform(20, 60)
            swing = radius * self.rng.uniform(0.1, 0.3) * self.rng.choice([-1, 1])
            turns = [math.radians(225) * place / (len(angles) - 1) for place in range(len(angles))]
            travels = [radius * turn + swing * math.sin(turn) for turn in turns]
            curve[side] = [f"{travel:.5g} mm" for travel in travels]
        return curve

    def trajectory(self):
        """Return strokes in time."""
        count = self.rng.randint(32, 60)  # six periods of the cutoff at least
        period = self.rng.uniform(8, 20)
        low = self.rng.uniform(0, 20)
        high = self.rng.uniform(60, 100)
        turns = [(1 - math.cos(2 * math.pi * row / period)) / 2 for row in range(count)]
        angles = [f"{low + (high - low) * turn:.5g} deg" for turn in turns]
        return {"time": [f"{0.05 * row:.4g} s" for row in range(count)], "angle": angles}

    # --- Sections ---------------------------------------------------------------------------------

    def sheath(self):
        """Return `[sheath]`: numbers, a route, a fitted coefficient, or a bend that varies."""
        sheath = self.of_sides("sheath", 0.3)
        for table in (sheath, sheath.get("flexor"), sheath.get("extensor")):
            if table is None:
                continue
            if self.happens(0.1):
                table.pop("friction", None)
                table["friction_from"] = "friction.toml"
            if self.happens(0.1):
                table.pop("bend_angle", None)
                table["path"] = "route.csv"
                if self.happens(0.5):
                    table["path_smoothing"] = "1 mm"
            elif self.happens(0.15):
                table["bend_angle"] = self.bend()
        return sheath

    def tendon(self, setting):
        """Return `[tendon]`; a gauge reads one pretension of both sides."""
        tendon = self.of_sides("tendon", 0.2)
        if self.happens(0.2):
            tendon["rope"] = self.rng.choice(["7x7", "7x19"])
        for side in ("flexor", "extensor"):
            tendon.get(side, {}).pop("breaking_force", None)  # one rope for both
        if setting.get("read", "pretension") != "pretension":
            for side in ("flexor", "extensor"):
                tendon.get(side, {}).pop("pretension", None)
        return tendon

    def spring(self):
        """Return `[spring]`, on some sides rigid or at the motor."""
        spring = self.of_sides("spring", 0.4)
        for table in (spring, spring.get("flexor"), spring.get("extensor")):
            if table is None:
                continue
            if self.happens(0.1):
                table["stiffness"] = "rigid"
            elif self.happens(0.1) and self.room["choice"] > 1:
                table["stiffness"] = ["rigid", "5 kN/m"]
                self.room["choice"] //= 2
            if self.happens(0.15):
                table["at"] = self.rng.choice(["joint", "motor"])
            elif self.happens(0.1) and self.room["choice"] > 1:
                table["at"] = ["joint", "motor"]
                self.room["choice"] //= 2
        return spring

    def joint(self):
        """Return `[joint]`: its own torque as a stiffness or a curve, and measured travels."""
        joint = {}
        if self.happens(0.2):
            joint = {key: self.number(f"joint.{key}") for key in ("stiffness", "rest_angle")}
        elif self.happens(0.15):
            joint["torque"] = self.torque()
        if self.happens(0.15):
            joint["excursion"] = self.excursion()
            if self.happens(0.3):
                joint["smoothing"] = "0.5 mm"
        if self.happens(0.2):
            joint["name"] = self.rng.choice(["ankle", "left wrist", "index-finger"])
        return joint

    def load(self):
        """Return `[load]`, with the torque of a task on some."""
        load = self.table("load", 0.5, without=("scale",))
        if self.happens(0.15):
            load["torque"] = self.torque()
            if self.happens(0.5):
                load["scale"] = self.number("load.scale")
        return load

    def setting(self):
        """Return `[setting]`, with the gauge that reads the pretension."""
        setting = self.table("setting", 0.12)
        if self.happens(0.2):
            setting["after"] = self.rng.choice(["flexion", "extension"])
        if self.happens(0.25):
            sides = ("flexor at joint", "extensor at joint", "flexor at motor", "extensor at motor")
            setting["read"] = self.rng.choice(["pretension", "motor torque", *sides])
        unit = "N m" if setting.get("read") == "motor torque" else "N"
        if self.happens(0.15):
            setting["reading_error"] = self.measure(0.1, 3, unit)
        if self.happens(0.2):
            setting["accuracy"] = self.measure(0, 6, self.rng.choice(["mm", unit]))
        return setting

    def motion(self):
        """Return `[motion]`: angles, directions and a speed, or a trajectory."""
        if self.happens(0.1):
            settings = {"cutoff": "4 Hz", "inertia": 0.08}
            chosen = {key: value for key, value in settings.items() if self.happens(0.4)}
            return {"trajectory": self.trajectory(), **chosen}
        motion = {}
        if self.happens(0.97):
            motion["elbow_angle"] = self.angles()
        if self.happens(0.25):
            motion["direction"] = self.rng.choice(
                ["flexion", "extension", ["extension"], ["extension", "flexion"]]
            )
        if self.happens(0.5):
            motion["speed"] = self.measure(5, 200, "deg/s")
        return motion

    def angles(self):
        """Return one angle, a list of them or a range."""
        form = self.rng.choice(["one", "list of one", "list", "range", "range", "range"])
        low, high = sorted(self.rng.sample(range(0, 121, 5), 2))
        if form == "one":
            return f"{low} deg"
        if form == "list of one":
            return [f"{high} deg"]
        if form == "list":
            return [f"{low} deg", f"{(low + high) / 2} deg", f"{high} deg"]
        return {"from": f"{low} deg", "to": f"{high} deg", "num": self.rng.randint(2, 8)}

    def model(self):
        """Return `[model]`."""
        options = {"slack": ("unilateral", "bilateral"), "reference": ("published", "initial")}
        return {key: self.rng.choice(words) for key, words in options.items() if self.happens(0.2)}

    def output(self):
        """Return `[output]`."""
        output = {}
        if self.happens(0.2):
            output["tables"] = self.rng.choice([["designs"], ["designs", "states"]])
        if self.happens(0.2) and output.get("tables") != ["designs"]:
            output["states"] = self.rng.sample(STATE_COLUMNS, self.rng.randint(1, 4))
        return output

    def uncertainty(self):
        """Return `[uncertainty]`."""
        uncertainty = {"draws": self.rng.choice([1, 2, 4, 8]), "usual": self.happens(0.3)}
        if self.happens(0.5):
            uncertainty["seed"] = self.rng.randint(0, 99)
        if self.happens(0.2):
            uncertainty["exact"] = self.rng.choice(["arm", "spring.stiffness"])
        return uncertainty

    def people(self, study):
        """Return `[people]`; put into the study what it then has to say of anchors."""
        stated = [name for name in ANCHORS if name in study["arm"]]
        people = {"seed": self.rng.randint(0, 99)}
        form = self.rng.choice(["survey", "file", "person"])
        if form == "survey":
            people["count"] = self.rng.randint(1, 6)
            people["source"] = "ansur2"
        else:
            people = {"file": "people.csv" if form == "file" else "person.csv"}
        if self.happens(0.3):
            people["sex"] = self.rng.choice(["male", "female", "both"])
        if people.get("sex", "both") == "both" and self.happens(0.3):
            people["women"] = 0.5
        if stated and form != "survey":
            whose = "measured" if form == "person" else "mean man"
            study["arm"]["anchors"] = whose
        elif self.happens(0.3):
            study["arm"]["anchors"] = "mean man"
        if "excursion" in study["joint"] and self.happens(0.5):
            study["joint"]["scale_with"] = "forearm_circumference"
        if "stiffness" in study["joint"] and self.happens(0.5):
            study["joint"]["stiffness_with"] = "arm_volume"
        return people

    def free_keys(self, study):
        """Return the keys of numbers that are single in the study, or not in it: rows may set them.

        They come in a random order.
        """
        of_bodies = ["arm.forearm_mass", "arm.forearm_com", "arm.load_distance"]
        free = []
        for key in NUMBERS:
            table, _, column = key.partition(".")
            stated = study.get(table, {}).get(column)
            is_single = stated is None or (isinstance(stated, str) and " to " not in stated)
            is_single = is_single and "+/-" not in str(stated)
            is_of_a_file = column in ("friction", "bend_angle") or table == "joint"
            is_of_a_body = "people" in study and key in (*of_bodies, *(f"arm.{a}" for a in ANCHORS))
            if is_single and not is_of_a_file and not is_of_a_body and key != "tendon.pretension":
                free.append(key)
        self.rng.shuffle(free)
        return free

    def cases(self, free):
        """Return `[[cases]]`, which set two of the keys that are free, and take these."""
        cases = []
        changed = [free.pop(), free.pop()]
        for number in range(self.rng.randint(1, 3)):
            case = {"name": f"case {number}"}
            for key in changed:
                table, _, column = key.partition(".")
                if self.happens(0.7):
                    case.setdefault(table, {})[column] = self.measure(*NUMBERS[key])
            cases.append(case)
        return cases

    def tables(self, study, free):
        """Return one or two of `[[table]]`, which set keys that are free, and take these."""
        free += [f"limits.{name}" for name in ("max_tension", "peak_motor_torque")]
        free = [key for key in free if key.partition(".")[2] not in study["limits"]]
        names = self.rng.sample(TABLE_NAMES, 2)
        tables = []
        for name in names[: self.rng.choice([1, 1, 2])]:
            table = {"name": name} | self.rng.choice([self.row_file, self.rows, self.sample])(free)
            role = self.rng.choice([None, None, "choice", "condition", "draw"])
            if role is not None:
                table["role"] = role
            self.is_uncertain |= role == "draw"
            tables.append(table)
        return tables

    def row_file(self, free):
        """Return a table of a file that sets keys which are free; without one, of rows."""
        known = [*free, "limits.max_spring_extension"]
        files = [name for name, keys in ROW_FILES.items() if set(keys) <= set(known)]
        if not files:
            return self.rows(free)
        file = self.rng.choice(files)
        free[:] = [key for key in free if key not in ROW_FILES[file]]
        return {"file": file}

    def rows(self, free):
        """Return a table of rows in the study, with a price or without."""
        keys = [free.pop() for _ in range(self.rng.randint(1, 3))]
        has_price = self.happens(0.5)
        rows = []
        for name in self.rng.sample(ROW_NAMES, self.rng.randint(1, 3)):
            row = {"name": name}
            for key in keys:
                if key is keys[0] or self.happens(0.8):
                    row[key] = self.measure(*self.range_of(key))
            if has_price:
                row["price (EUR)"] = self.rng.choice([1, 2.5, "3", "on request", "1,200", None])
            rows.append(row)
        return {"rows": rows}

    def range_of(self, key):
        """Return the lowest and the highest value of a number or a limit, and its unit."""
        return LIMITS[key.removeprefix("limits.")] if key.startswith("limits.") else NUMBERS[key]

    def sample(self, free):
        """Return a table of rows that are drawn between bounds."""
        between = {}
        for key in (key for key in list(free) if not key.startswith("limits.")):
            low, high, unit = NUMBERS[key]
            first, second = self.ends(low, high)
            between[key] = f"{said(first, unit)} to {said(second, unit)}"
            free.remove(key)
            if len(between) == 2:
                break
        kind = self.rng.choice(["sobol", "latin-hypercube", "random"])
        return {"sample": kind, "count": self.rng.randint(1, 3), "seed": 3, "between": between}

    def limits(self, study):
        """Return `[limits]`: those that the study gives what they need."""
        motion = study["motion"]
        spring = study["spring"]
        springs = [spring, spring.get("flexor", {}), spring.get("extensor", {})]
        is_plain = not any("at" in each or "rigid" in each.get("stiffness", ()) for each in springs)
        has_free_length = "free_length" in spring or "free_length" in springs[1]
        has_room = has_free_length and is_plain and "excursion" not in study["joint"]
        has_strap = "contact_width" in study["arm"] and (
            "excursion" not in study["joint"] or "contact_radius" in study["arm"]
        )
        forbidden = set()
        if "speed" not in motion and "trajectory" not in motion:
            forbidden.update(OF_A_SPEED)
        if not has_room:
            forbidden.add("min_spring_room")
        if not has_strap:
            forbidden.add("max_contact_pressure")
        limits = {}
        for name, bounds in LIMITS.items():
            chance = 0.06 if name in OF_A_SPEED else 0.12
            if name not in forbidden and self.happens(chance):
                limits[name] = self.measure(*bounds)
                if self.happens(0.15) and self.room["choice"] > 1:
                    limits[name] = sorted({self.measure(*bounds), self.measure(*bounds)})
                    self.room["choice"] //= 2
        return limits

    def goals(self, study):
        """Return `[design]`."""
        design = {}
        counts = self.is_uncertain or "people" in study
        if self.happens(0.3):
            moves = study["motion"].keys() & {"speed", "trajectory"}
            known = (*GOALS, *GOALS_OF_A_MOTION) if moves else GOALS
            goals = self.rng.sample(known, self.rng.randint(1, 3))
            if not counts:
                goals = [goal for goal in goals if goal != "served_at"] or ["tolerance"]
            if "price" in str(study.get("table")) and self.happens(0.5):
                goals[0] = "price"
            design["minimise"] = goals[:1] if self.happens(0.5) else goals[0]
            if goals[1:]:
                design["maximise"] = goals[1:]
        if self.happens(0.25) and counts:
            design["serve"] = self.rng.choice(["50 %", 0.8, 1])
        design["verify"] = self.rng.choice([0, 200, 1000])
        if self.happens(0.2):
            design["advice"] = self.happens(0.5)
        if self.happens(0.2):
            design["prove"] = self.rng.choice([[0], ["0"], 0])
        if "people" in study and self.happens(0.3):
            design["by"] = "sex"
        if self.happens(0.25):
            is_torque = study["setting"].get("read") == "motor torque"
            given = self.measure(1, 4, "N m") if is_torque else self.measure(20, 400, "N")
            design["pretension"] = self.rng.choice(["middle", "least", given])
        if self.happens(0.15):
            given = ["load.mass", "arm.b1", "spring.stiffness", "spool.ratio", "case"]
            given += [table["name"] for table in study.get("table", ())]
            design["conditions"] = self.rng.sample(given, self.rng.randint(0, 3))
        return design
