"""Files that hold data and nothing else: what would run code, draw in other files, or fill the memory, is refused.

Each check is made before the library that understands the format sees the file. Python's own serialisations (pickle,
and what builds on it) are in no list of readers: reading them runs what they say.
"""
