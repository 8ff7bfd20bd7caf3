"""Verification: ehamj against independent solutions, one case each; `verify` runs them all."""

from ehamj.verify.case import Case, Finding, Outcome, Subject, run_case
from ehamj.verify.cases import CASES, verify
from ehamj.verify.table import to_dict, write_table

__all__ = ["CASES", "Case", "Finding", "Outcome", "Subject", "run_case", "to_dict", "verify", "write_table"]
