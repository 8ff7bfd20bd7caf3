"""The paper, reproduced number by number, with what does not reproduce said aloud."""

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any

from ehamj.paper.cases import CASES, PaperCase, PaperStudy, paper_cases
from ehamj.paper.claims import Claim, claims
from ehamj.paper.table import PaperNumber, paper_table


@dataclass(frozen=True)
class Reproduction:
    """The whole reproduction: cases by name, variants beyond the paper's ten, the table and the claims."""

    study: PaperStudy
    cases: dict[str, PaperCase]
    variants: dict[str, PaperCase]
    table: tuple[PaperNumber, ...] = field(repr=False)
    claims: tuple[Claim, ...] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, numbers as numbers."""
        return {
            "study": self.study.to_dict(),
            "cases": {name: case.to_dict() for name, case in self.cases.items()},
            "variants": {name: case.to_dict() for name, case in self.variants.items()},
            "table": [number.to_dict() for number in self.table],
            "claims": [claim._asdict() for claim in self.claims],
            "versions": {name: version(name) for name in ("ehamj", "numpy", "scipy")},
        }


def reproduce(study: PaperStudy | None = None) -> Reproduction:
    """Compute the paper's ten cases, four variants (the valve at ±90 %, the 400 Hz valve, both designs under the other
    reading), and everything that the paper states about them.

    Raises:
        InputError: if the study is not physical.
    """
    study = study or PaperStudy()
    every = paper_cases(study)
    cases = {name: every[name] for name in CASES}
    variants = {name: case for name, case in every.items() if name not in CASES}
    return Reproduction(study, cases, variants, paper_table(study, every), claims(study, every))
