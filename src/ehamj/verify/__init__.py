"""Verification: ehamj against independent solutions, one case each; `verify` runs them all."""

from ehamj.verify import cases
from ehamj.verify.case import CASES, Case, CaseOutcome, Finding, Subject, case, run_case, verify
from ehamj.verify.table import to_dict, write_table

__all__ = [
    "CASES", "Case", "CaseOutcome", "Finding", "Subject", "case", "cases", "run_case", "to_dict", "verify",
    "write_table",
]  # fmt: skip
