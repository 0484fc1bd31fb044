"""Kind of the task that answers a design question: record, tables, who runs and draws it."""

from tendon_cli.verbs.registry import FlagOption, SettingOption, TableKind, TaskKind

DESIGN = TaskKind(
    verb="design",
    help="Find the best choice and its window of pretension: what limits it, and what would help.",
    noun="an answer",
    record="design.json",
    counts=("choices", "conditions", "feasible"),
    tables=(
        TableKind("choices", axes="tendon_cli.cube.axes.choice_axes"),
        TableKind("conditions"),
        TableKind("persons"),
        TableKind("draws"),
    ),
    task="tendon_cli.answers.choices.Choices",
    reads="tendon_cli.verbs.answer_record.as_answer",
    result="tendon_cli.answers.answer.Answer",
    suffix="-design",
    size="tendon_cli.answers.size.size_of_question",
    draw="tendon_cli.figures.answer_figures.draw_answer",
    check="tendon_cli.checks.check_answer.check_answer",
    compare="tendon_cli.checks.compare_answers.compare_answers",
    export="tendon_cli.exports.export.export_answer",
    page="tendon_cli.reports.design_page.design_page",
    setting=SettingOption(
        flag="--prove",
        metavar="CHOICE",
        help="prove the window of this choice, too: its row in choices.parquet; repeatable",
        key="design.prove",
    ),
    whole=FlagOption(
        flag="--why",
        help="print the whole answer: all reasons, parts, alternatives and notes",
    ),
)
