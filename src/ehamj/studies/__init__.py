"""Studies: one file per question, a frozen configuration and a function that answers it with a table or a dataset."""
