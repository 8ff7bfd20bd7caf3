"""The documentation site: theory in chapters, equations typeset, and the reference, made from the program."""
