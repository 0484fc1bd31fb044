"""Truths that hold for any valid study: its answer, its sweep and a state, held to each other."""

import copy
import json
import re

import numpy as np

ODD = re.compile(r"\b(nan|inf|None(?! of\s+[0-9]))\b")
"""Words that no text for a reader holds."""
MOST_BYTES_OF_A_PAGE = 5_000_000
ROUNDING = 1e-6
"""Share of a pretension by which two ways of computing it may differ."""
DRAWS = 256
"""Draws of a sweep that is held to a share of a fresh sample."""
CHANCE = 0.15
"""Most by which shares of two samples, of DRAWS and of 200 draws or more, differ by chance."""
MOST = 1e7
"""Largest pretension that a study may state, N; windows without an upper end may lie above."""


def try_valid(file):
    """Answer a study, sweep it and work out a state; hold each to what must be true of it."""
    import tendon_cli as tendon

    study = tendon.study(file)
    answer = tendon.design(study, file.with_name("answer"), jobs=1, overwrite=True)
    check_text(answer.text)
    check_read_again(answer, file)
    check_text_of_record(answer)
    check_pretension(answer)
    content = json.loads(file.read_text("utf-8"))
    run = tendon.sweep(tried(content, file), file.with_name("run"), jobs=1, overwrite=True)
    check_text(run.text)
    check_read_again(run, file)
    check_sweep(answer, content, file)
    for reversal in (False, True):
        page = tendon.state(study, reversal=reversal)
        check_text(page.text)
        json.dumps(page.record, allow_nan=False)


def check_read_again(result, file):
    """Assert that a result is the same once it is read, and that every command takes it."""
    import tendon_cli as tendon
    from tendon_cli.errors import TendonError

    folder = file.with_name("answer" if hasattr(result, "choices") else "run")
    try:
        again = tendon.open(folder)
        # The first line of a run says how long it took.
        skipped = 0 if hasattr(result, "choices") else 1
        assert again.text.splitlines()[skipped:] == result.text.splitlines()[skipped:]
        check_text(tendon.check(folder).text)
        changes = tendon.check(folder, baseline=folder)
        assert changes.holds or not tendon.check(folder).holds, changes.text
        check_text(tendon.compare(folder, folder).text)
        page = tendon.report(folder, file.with_name("page.html"), overwrite=True)
        assert page.stat().st_size < MOST_BYTES_OF_A_PAGE
    except TendonError as error:
        raise AssertionError(f"{type(error).__name__} of its own {folder.name}: {error}") from error


def tried(content, file):
    """Return the study of some content, its intervals sampled, from the folder of a file."""
    from tendon_cli.studies.load import load_study

    other = file.with_name("other.yaml")
    other.write_text(json.dumps(without_intervals(content)), "utf-8")
    return load_study(other)


def without_intervals(content):
    """Return a study with three values of each interval."""
    if isinstance(content, list):
        return [without_intervals(item) for item in content]
    if not isinstance(content, dict):
        return content
    if content.keys() == {"from", "to"}:
        return content | {"num": 3}
    return {key: without_intervals(value) for key, value in content.items()}


def check_text(text):
    """Assert that a text has no number that is none."""
    odd = ODD.search(text)
    assert odd is None, text[max(0, odd.start() - 200) : odd.end() + 100]


def check_text_of_record(answer):
    """Assert that the text follows from the record as `design.json` holds it."""
    from tendon_cli.answers.text import answer_text
    from tendon_cli.verbs.answer_record import as_answer

    record = json.loads(json.dumps(answer.record, allow_nan=False))
    assert answer_text(as_answer(record)) == answer.record["text"]


def check_pretension(answer):
    """Assert that the pretension of the best choice lies in its window."""
    best = answer.best
    if best is None or answer.record["question"]["pretension"] is not None:
        return
    low = best["pretension_from"]
    high = np.inf if best["pretension_to"] is None else best["pretension_to"]
    pretension = best["pretension"]
    slack = ROUNDING * abs(pretension)
    assert low - slack <= pretension <= high + slack, f"{low} <= {pretension} <= {high}"
    if best["served"] is not None:
        assert best["served_at"] <= best["served"] + ROUNDING, f"{best['served_at']} served"


def check_sweep(answer, content, file):
    """Assert that a sweep at the pretension of the best choice serves the share that is claimed.

    The claim may be smaller: it holds between the angles of the study, too. A share of a fresh
    sample is held to draws of another seed. A study that states a pretension with a law draws other
    values of all numbers once it has a single one.
    """
    import tendon_cli as tendon

    best = answer.best
    uncertain = tendon.study(file).uncertain
    is_drawn = any(key.startswith("tendon.pretension") for key in uncertain)
    # A sweep draws no usual deviations.
    is_usual = content.get("uncertainty", {}).get("usual", True)
    # F0 of the study's own arm is another reading on the arms of conditions and draws.
    is_of_own_arm = answer.record["question"].get("shows_own_f0", False)
    if best is None or "people" in content or is_drawn or is_usual or is_of_own_arm:
        return
    low = best["pretension_from"]
    high = best["pretension_to"]
    at_an_end = best["pretension"] <= low * (1 + ROUNDING)
    if high is not None:
        at_an_end |= best["pretension"] >= high * (1 - ROUNDING)
    is_endless = best["pretension"] > MOST
    if at_an_end or is_endless or answer.record["question"]["pretension"] is not None:
        return
    chosen = choice_of(content, best, answer.record["question"]["choices"], tendon.study(file))
    chance = 0.0
    if answer.record["question"].get("set_by_sample"):
        chosen["uncertainty"] |= {"draws": DRAWS, "seed": 1 + chosen["uncertainty"].get("seed", 1)}
        chance = CHANCE
    designs = tendon.sweep(tried(chosen, file), jobs=1).designs
    feasible = designs["feasible"].astype(bool)
    drawn = ["draw"] if "draw" in designs else []
    drawn += [table["name"] for table in content.get("table", ()) if table.get("role") == "draw"]
    if drawn:
        feasible = feasible.groupby([designs[name] for name in drawn], observed=True).all()
    share = feasible.mean()
    claimed = 1.0 if best["served_at"] is None else best["served_at"]
    assert share >= claimed - ROUNDING - chance, (
        f"{share:.4g} of the sweep is feasible at {best['pretension']} N, {claimed:.4g} is claimed"
    )


def choice_of(content, best, axes, study):
    """Return the study with the values of a choice in place of its axes, at its pretension.

    Args:
        content: The study as it was written.
        best: Row of the choice.
        axes: Axes of the choices, from the record.
        study: The study as it was read.
    """
    from tendon_cli.studies.study import keys

    chosen = copy.deepcopy(content)
    chosen.pop("figure", None)
    chosen["allow_implausible"] = True  # as the pretension may be
    chosen["output"] = {"tables": ["designs"]}
    tendon = chosen.setdefault("tendon", {})
    for side in ("flexor", "extensor"):
        tendon.get(side, {}).pop("pretension", None)
    tendon["pretension"] = f"{best['pretension']!r} N"
    tables_of = {table.key: table for table in study.row_tables}
    for axis in axes:
        key = axis["key"]
        value = best[axis["column"]]
        if key == "case":
            chosen["cases"] = [case for case in chosen["cases"] if case["name"] == value]
            continue
        if key in tables_of:
            place = [table["name"] for table in chosen["table"]].index(key)
            columns = tables_of[key].document()["rows"]
            row = 1 + tables_of[key].names.index(value)
            rows = {column[0]: [column[row]] for column in columns}
            chosen["table"][place] = {"name": key, "role": "choice", "rows": rows}
            continue
        *tables, name = key.split(".")
        table = chosen
        for part in tables:
            table = table.setdefault(part, {})
        is_angle = key in keys() and keys()[key].number.quantity.dimension == "angle"
        table[name] = f"{value!r} rad" if is_angle else value
    return chosen
