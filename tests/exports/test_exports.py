"""Exports for the next tool say what the answer says: a balance, its states, its numbers."""

import csv
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import UsageError
from tendon_cli.exports.mujoco import Machine, Strand, machine_xml

ROOT = Path(__file__).parents[2]
SUIT = {
    "name": "suit",
    "spring": {"stiffness": ["4 kN/m", "5 kN/m"]},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "5 kg"]},
    "arm": {"upper_arm_angle": "10 deg"},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}
VARIANTS = {
    "plain": {},
    "soft anchors": {"anchor": {"stiffness": "20 kN/m"}},
    "spring at the motor": {"spring": {"stiffness": "5 kN/m", "at": "motor"}},
    "one rigid spring": {"spring": {"flexor": {"stiffness": "rigid"}, "stiffness": "5 kN/m"}},
    "measured from 0 deg": {"model": {"reference": "initial"}},
    "a stiff joint": {"joint": {"stiffness": "1 N m/rad", "rest_angle": "60 deg"}},
}
GRAVITY = 9.81


@pytest.fixture(scope="session")
def answer():
    return tendon.design(SUIT)


@pytest.fixture(scope="session")
def variants():
    return {name: tendon.design(SUIT | changed) for name, changed in VARIANTS.items()}


def tree_of(file):
    """Return the root of a model that this test has written."""
    return ET.fromstring(file.read_text())  # noqa: S314


def numbers_of(text):
    return [float(part) for part in text.split()]


# --- MuJoCo ---------------------------------------------------------------------------------------


class PlainEngine:
    """Forces at the joints of an exported model, by elementary geometry from its own numbers."""

    def __init__(self, file):
        self.root = tree_of(file)
        sites = {site.get("name"): site for site in self.root.iter("site")}
        self.r, self.q, self.start = (
            np.array(numbers_of(sites[name].get("pos")))[[0, 2]]
            for name in ("r", "q", "extensor start")
        )
        pulley = next(self.root.iter("geom"))
        self.radius = numbers_of(pulley.get("size"))[0]
        self.lean = numbers_of(self.body("upper arm").get("axisangle"))[3]
        self.parts = {part.get("name"): part for part in self.root.find("tendon")}

    def body(self, name):
        return next(body for body in self.root.iter("body") if body.get("name") == name)

    def flexor_path(self, elbow):
        turn = np.array([[np.cos(elbow), -np.sin(elbow)], [np.sin(elbow), np.cos(elbow)]])
        return np.linalg.norm(self.r - turn @ self.q)

    def extensor_path(self, elbow):
        reach = np.linalg.norm(self.start)
        tangent = np.sqrt(reach**2 - self.radius**2)
        opening = 2.0 * np.arctan2(self.start[1], -self.start[0]) + elbow
        return 2.0 * tangent + self.radius * (opening - 2.0 * np.arccos(self.radius / reach))

    def tension(self, name, length):
        part = self.parts[name]
        natural = numbers_of(part.get("springlength"))[1]
        return float(part.get("stiffness")) * max(length - natural, 0.0)

    def tensions(self, elbow, position):
        """Return the tensions of both tendons and of both springs, N."""
        _, spool, *junctions = position
        found = []
        for side, end, path in zip(
            ("flexor", "extensor"),
            junctions,
            (self.flexor_path(elbow), self.extensor_path(elbow)),
            strict=True,
        ):
            body = self.body(f"{side} junction")
            joint = body.find("joint")
            lead = numbers_of(body.get("pos"))[1] + end - float(joint.get("ref"))
            coefficient = float(self.parts[f"{side} tendon"].find("joint").get("coef"))
            tendon_length = coefficient * spool - end
            found.append(self.tension(f"{side} tendon", tendon_length))
            found.append(self.tension(f"{side} spring", lead + path))
        return found

    def left_over(self, key):
        """Return what is left of the forces at junctions, elbow and spool at a keyframe."""
        position = numbers_of(key.get("qpos"))
        elbow = position[0]
        flexor_tendon, flexor, extensor_tendon, extensor = self.tensions(elbow, position)
        step = 1e-6
        flexor_arm = (self.flexor_path(elbow - step) - self.flexor_path(elbow + step)) / 2.0 / step
        extensor_arm = self.extensor_path(elbow + step) - self.extensor_path(elbow - step)
        masses = [body.find("inertial") for body in self.root.iter("body")]
        weights = {
            name: float(inertial.get("mass"))
            for name, inertial in zip(
                [body.get("name") for body in self.root.iter("body")], masses, strict=True
            )
            if inertial is not None
        }
        com = -numbers_of(self.body("forearm").find("inertial").get("pos"))[2]
        moment = weights["forearm"] * com
        if "load" in weights:
            moment += weights["load"] * -numbers_of(self.body("load").get("pos"))[2]
        joint = self.body("forearm").find("joint")
        passive = float(joint.get("stiffness")) * (elbow - float(joint.get("springref")))
        torque = GRAVITY * moment * np.sin(elbow + self.lean) + passive
        radii = [
            float(self.parts[f"{side} tendon"].find("joint").get("coef"))
            for side in ("flexor", "extensor")
        ]
        motor = numbers_of(key.get("ctrl"))[0]
        return [
            flexor_tendon - flexor,
            extensor_tendon - extensor,
            flexor_arm * flexor - extensor_arm / 2.0 / step * extensor - torque,
            radii[0] * flexor_tendon + radii[1] * extensor_tendon - motor,
        ]


@pytest.mark.parametrize("name", VARIANTS)
def test_an_exported_model_rests_in_its_keyframes(variants, name, tmp_path):
    file = variants[name].export("mujoco", tmp_path / "suit.xml")
    engine = PlainEngine(file)
    keys = list(engine.root.iter("key"))
    assert len(keys) == 3
    for key in keys:
        np.testing.assert_allclose(engine.left_over(key), 0.0, atol=2e-6)


@pytest.mark.parametrize("name", VARIANTS)
def test_the_balance_of_a_model_is_that_of_the_answer_without_friction(variants, name, tmp_path):
    answer = variants[name]
    file = answer.export("mujoco", tmp_path / "suit.xml")
    best = answer.best
    chosen = {"tendon.pretension": best["pretension"], "sheath.friction": 0.0}
    if "spring_stiffness" in best:
        chosen["spring.stiffness"] = best["spring_stiffness"]
    study = answer.study.vary(**chosen, **{"load.mass": 5.0})
    angles = np.radians([0.0, 45.0, 90.0])
    states = tendon.states(study, angles)
    for place, key in enumerate(tree_of(file).iter("key")):
        elbow, spool, *_ = numbers_of(key.get("qpos"))
        assert elbow == pytest.approx(angles[place])
        assert spool == pytest.approx(states["spool_angle"][place], abs=1e-9)
        torque = numbers_of(key.get("ctrl"))[0]
        assert torque == pytest.approx(states["motor_torque"][place], abs=1e-9)


def interpreter_with_mujoco():
    """Return a Python that has MuJoCo; None if none is known here."""
    known = (sys.executable, os.environ.get("TENDON_MUJOCO", ""), ROOT / ".venv-verify/bin/python")
    for candidate in map(str, known):
        if Path(candidate).is_file():
            asked = subprocess.run(
                [candidate, "-c", "import mujoco"], check=False, capture_output=True
            )
            if asked.returncode == 0:
                return candidate
    return None


def test_mujoco_finds_the_keyframes_at_rest(variants, tmp_path):
    python = interpreter_with_mujoco()
    if python is None:
        pytest.skip("no MuJoCo here: TENDON_MUJOCO may name a Python that has it")
    files = []
    for place, answer in enumerate(variants.values()):
        files.append(str(answer.export("mujoco", tmp_path / f"{place}.xml")))
    words = [python, "-m", "verification.holds_at_rest", *files]
    done = subprocess.run(words, check=False, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_no_remark_ends_the_comment():
    strand = Strand(2.0, 1e5, 5e3, 100.0)
    arm = [0.04, 0.15, 0.02, 0.15, 0.045, 0.0, 1.5, 0.17, 0.0, 0.3]
    machine = Machine(*arm, strand, strand, 0.03, 0.6, from_initial=False)
    text = machine_xml(machine, 'a"<b>', ["--> <mujoco>", "a---b", "&amp"])
    root = ET.fromstring(text)  # noqa: S314
    assert root.get("model") == 'a"<b>'


def test_measured_travels_have_no_path_for_mujoco(tmp_path):
    excursion = {
        "angle": ["0 deg", "45 deg", "90 deg"],
        "flexor": ["0 mm", "40 mm", "100 mm"],
        "extensor": ["0 mm", "35 mm", "71 mm"],
    }
    answer = tendon.design(
        {
            "joint": {"excursion": excursion},
            "spring": {"stiffness": "5 kN/m"},
            "spool": {"ratio": 0.6},
            "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4}},
        }
    )
    with pytest.raises(UsageError, match="no path for MuJoCo"):
        answer.export("mujoco", tmp_path / "suit.xml")
    assert answer.export("controller", tmp_path / "suit.csv").exists()
    assert answer.export("parameters", tmp_path / "numbers.csv").exists()


# --- Tables ---------------------------------------------------------------------------------------


def rows_of(file):
    with file.open(newline="") as opened:
        return list(csv.DictReader(opened))


def test_a_controller_has_the_torque_and_the_angle_of_every_state(answer, tmp_path):
    rows = rows_of(answer.export("controller", tmp_path / "c.csv"))
    heads = list(rows[0])
    assert heads[0] == "direction (1 flexion; -1 extension)"
    assert "capstan friction" in heads[3]
    best = answer.best
    study = answer.study.vary(
        **{
            "tendon.pretension": best["pretension"],
            "spring.stiffness": best["spring_stiffness"],
        }
    )
    angles = answer.study.angles
    assert len(rows) == 2 * 2 * len(angles)
    for load in (0.0, 5.0):
        for sign in (1, -1):
            states = tendon.states(study.vary(**{"load.mass": load}), angles, sign == 1)
            kept = [
                row
                for row in rows
                if int(row[heads[0]]) == sign and float(row["load_mass (kg)"]) == load
            ]
            for column, head in (("motor_torque", heads[3]), ("spool_angle", heads[4])):
                written = [float(row[head]) for row in kept]
                np.testing.assert_allclose(written, states[column], rtol=1e-12, atol=1e-12)


def test_the_numbers_of_the_list_are_the_suit(answer, tmp_path):
    rows = rows_of(answer.export("parameters", tmp_path / "p.csv", choice=1))
    assert list(rows[0]) == ["name", "value", "unit", "source"]
    found = {row["name"]: row for row in rows}
    assert len(found) == len(rows)
    assert found["spring.flexor.stiffness"]["source"] == "choice"
    assert float(found["spring.flexor.stiffness"]["value"]) == 5000.0
    assert found["arm.b1"]["unit"] == "m"
    chosen = answer.choices.iloc[1]
    for name in ("pretension", "set_flexor_tension", "max_tension"):
        assert float(found[name]["value"]) == chosen[name]
    # A study of nothing but these numbers is the same suit.
    settings = {"motion.elbow_angle": ["0 rad", "1 rad"]}
    for name, row in found.items():
        table = name.partition(".")[0]
        if "." in name and table not in ("tendon", "study", "setting", "joint"):
            value = row["value"] if row["value"] == "rigid" else float(row["value"])
            settings[name] = f"{value!r} rad" if row["unit"] == "rad" else value
    settings["tendon.pretension"] = float(found["pretension"]["value"])
    again = tendon.states(tendon.study({}).vary(**settings), [0.5])
    study = answer.study.vary(
        **{
            "tendon.pretension": chosen["pretension"],
            "spring.stiffness": 5000.0,
            "load.mass": 0.0,
        }
    )
    np.testing.assert_allclose(
        again["motor_torque"], tendon.states(study, [0.5])["motor_torque"], rtol=1e-12
    )


def test_the_parts_of_a_choice_stand_in_the_list_with_what_they_carry(tmp_path):
    springs = [
        {"name": "A", "spring.stiffness": "5 kN/m", "price": 3, "supplier": "one"},
        {"name": "B", "spring.stiffness": "8 kN/m", "price": 4, "supplier": "two, or one"},
    ]
    spools = [{"name": "wide", "spool.ratio": 0.5, "price": 10}]
    tables = [{"name": "spring", "rows": springs}, {"name": "spool", "rows": spools}]
    answer = tendon.design({"table": tables, "load": {"mass": ["0 kg", "5 kg"]}}, tmp_path / "a")
    for row, part in enumerate(springs):
        listed = rows_of(answer.export("parameters", tmp_path / f"{row}.csv", choice=row))
        values = {entry["name"]: entry["value"] for entry in listed}
        assert (values["spring"], values["spool"]) == (part["name"], "wide")
        assert values["spring.supplier"] == part["supplier"]
        assert float(values["spring.price"]) == part["price"]
        assert float(values["price"]) == 2 * part["price"] + 10
        stiffness = float(part["spring.stiffness"].split()[0])
        assert float(values["spring.flexor.stiffness"]) == 1000.0 * stiffness


def ordered(answer, file, **options):
    """Return an order list by its parts."""
    return {row["part"]: row for row in rows_of(answer.export("parts", file, **options))}


SPRINGS_TO_ORDER = {
    "plain": {"spring of 4 kN/m": "2"},
    "spring at the motor": {"spring of 5 kN/m": "2"},
    "one rigid spring": {"spring of 5 kN/m": "1"},
    "sides": {"spring of 4 kN/m": "1", "spring of 5 kN/m": "1"},
}


def test_an_order_list_has_the_spring_of_each_side(variants, tmp_path):
    sides = {"flexor": {"stiffness": "4 kN/m"}, "extensor": {"stiffness": "5 kN/m"}}
    answers = variants | {"sides": tendon.design(SUIT | {"spring": sides})}
    found = {}
    for name in SPRINGS_TO_ORDER:
        parts = ordered(answers[name], tmp_path / f"{name}.csv")
        springs = {part: row["quantity"] for part, row in parts.items() if "spring" in part}
        found[name] = springs
        assert parts["rope"]["quantity"] == "2"
        assert parts["strap"]["quantity"] == parts["motor"]["quantity"] == "1"
    assert found == SPRINGS_TO_ORDER


def test_an_order_list_of_catalogues_sums_to_the_price_of_the_choice(tmp_path):
    springs = [
        {"name": "A", "spring.stiffness": "5 kN/m", "price": 3, "supplier": "one"},
        {"name": "B", "spring.stiffness": "8 kN/m", "price": 4, "supplier": "=two, or one"},
    ]
    spools = [{"name": "wide", "spool.ratio": 0.5, "price": 10}]
    tables = [{"name": "spring", "rows": springs}, {"name": "spool", "rows": spools}]
    answer = tendon.design({"table": tables, "load": {"mass": ["0 kg", "5 kg"]}}, tmp_path / "a")
    for row, part in enumerate(springs):
        parts = ordered(answer, tmp_path / f"{row}.csv", choice=row)
        assert parts[f"spring {part['name']}"]["quantity"] == "2"
        supplier = parts[f"spring {part['name']}"]["supplier"]
        assert supplier == part["supplier"].replace("=", "'=")  # no spreadsheet runs it
        priced = [one for one in parts.values() if one["price"]]
        total = sum(int(one["quantity"]) * float(one["price"]) for one in priced)
        assert total == 2 * part["price"] + 10 == answer.choices["price"][row]


def test_persons_leave_the_study_s_own_arm(tmp_path):
    study = SUIT | {"people": {"count": 8}, "design": {"verify": 0, "serve": 0.5}}
    del study["arm"]
    answer = tendon.design(study)
    rows = {row["name"]: row for row in rows_of(answer.export("parameters", tmp_path / "p.csv"))}
    assert rows["arm.forearm_mass"]["source"] == "mean man of the people"
    table = rows_of(answer.export("controller", tmp_path / "c.csv"))
    assert len(table) == 2 * 2 * len(answer.study.angles)


# --- The command ----------------------------------------------------------------------------------

FORMS = {
    "mujoco": "a.xml",
    "controller": "b.csv",
    "parameters": "c.csv",
    "parts": "d.csv",
}
"""A file of each form of export."""


def test_the_command_writes_each_form_and_never_over_another_file(tendon, workplace):
    (workplace / "suit.toml").write_text('[spool]\nratio = 0.6\n[spring]\nstiffness = "5 kN/m"\n')
    assert tendon("design", "suit.toml", "--no-figures").exit == 0
    folder = "results/suit-design"
    for form, file in FORMS.items():
        for _ in range(2):  # a file of tendon's own is written anew
            assert tendon("export", folder, "--to", form, file).exit == 0
        theirs = workplace / f"theirs{Path(file).suffix}"
        theirs.write_text("name,value,unit,source\na,1,m,me\n")
        refused = tendon("export", folder, "--to", form, theirs.name)
        assert refused.exit == 2
        assert "tendon did not write it" in refused.err
        assert theirs.read_text().endswith("me\n")


@pytest.mark.parametrize(
    ("words", "exit_code", "says"),
    [
        (("--to", "mujoko", "a.xml"), 2, 'did you mean "mujoco"?'),
        (("--to", "mujoco", "a.csv"), 2, "does not end in .xml"),
        (("--to", "controller", "a.csv", "--choice", "7"), 2, "has no choice 7"),
        (("--to", "controller", "a.csv", "--table", "choices"), 2, "--table is for tables"),
        (("--to", "controller", "a.csv", "--units", "study"), 2, "--units is for tables"),
        (("a.csv", "--choice", "0"), 2, "--choice needs --to"),
    ],
)
def test_what_does_not_fit_together_is_said(tendon, workplace, words, exit_code, says):
    tendon_cli = __import__("tendon_cli")
    tendon_cli.design({"spool": {"ratio": 0.6}, "name": "suit"}, workplace / "done")
    done = tendon("export", "done", *words)
    assert done.exit == exit_code
    assert says in done.err


def test_a_run_has_no_choice_to_export(tendon, workplace):
    __import__("tendon_cli").sweep({}, workplace / "run")
    done = tendon("export", "run", "--to", "parameters", "a.csv")
    assert done.exit == 3
    assert "holds a sweep, expected an answer" in done.err
