"""What the command ``identify --plan`` prints: what each test would tell, and which to make next."""

from typing import TYPE_CHECKING

from ehamj.cli.printing import print_table, say

if TYPE_CHECKING:
    from ehamj.identification.planning.outcome import Plan


def print_plan(plan: "Plan") -> None:
    """Print the plan: test by parameter, deviations along the recommended tests, and both in words."""
    from ehamj.campaign.names import short_names
    from ehamj.identification.planning.information import TOLD
    from ehamj.identification.planning.page import CAUTION, deviation_table, told_apart
    from ehamj.pages.words import DASH

    if plan.forecasts:
        names = list(short_names(plan.keys).values())
        rows = [
            [name, *(DASH if factor < TOLD else f"{factor:.3g}" for factor in one.factors)]
            for name, one in told_apart(plan)
        ]
        print_table("By which factor each test alone would sharpen each value", ["test", *names], rows, whole=0, gap=1)
    if (table := deviation_table(plan)).rows:
        print_table(table.title, table.head, table.rows, whole=0, gap=1)
    for answer in plan.answers:
        say(f"- {answer}")
    for name, why in plan.refused.items():
        say(f"note: {name}: cannot be predicted: {why}")
    say(f"note: {CAUTION}")
