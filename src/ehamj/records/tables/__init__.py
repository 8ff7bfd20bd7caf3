"""Tables of text as loggers and spreadsheets write them: understood first, and then read."""

from ehamj.records.tables.layout import Column
from ehamj.records.tables.looks import looks_like_table
from ehamj.records.tables.record import read_table_record
from ehamj.records.tables.table import Table, read_table

__all__ = ["Column", "Table", "looks_like_table", "read_table", "read_table_record"]
