"""What the command ``identify --plan`` prints: what each test would tell, and which to make next."""

from typing import TYPE_CHECKING

from ehamj.cli.printing import print_table, say

if TYPE_CHECKING:
    from ehamj.identification.planning.outcome import Plan


def print_plan(plan: "Plan") -> None:
    """Print the plan: test by parameter, deviations along the recommended tests, and both in words."""
    from ehamj.identification.planning.page import candidate_table, deviation_table

    for table in (candidate_table(plan), deviation_table(plan)):
        if table.rows:
            print_table(table.title, table.head, table.rows)
    for answer in plan.answers:
        say(f"- {answer}")
    for name, why in plan.refused.items():
        say(f"note: {name}: cannot be predicted: {why}")
