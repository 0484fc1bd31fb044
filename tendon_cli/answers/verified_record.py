"""The judgement of a fresh sample as it is recorded."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tendon_cli.answer_record import FreshRecord, VerifiedRecord
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.windows.verification import Verified

if TYPE_CHECKING:
    from tendon_cli.studies.fresh_sample import FreshSample


def fresh_record(sample: FreshSample) -> FreshRecord:
    """Return the record of a fresh sample."""
    return FreshRecord(
        count=len(sample),
        persons=sample.persons,
        kind="persons" if sample.draws_persons else "draws",
    )


def verified_record(judged: Verified) -> VerifiedRecord:
    """Return the record of the judgement on a choice."""
    return VerifiedRecord(
        value=judged.value,
        interval_95=[*judged.interval],
        of=len(judged.sample),
        from_=finite_or_none(judged.low),
        to=finite_or_none(judged.high),
    )
