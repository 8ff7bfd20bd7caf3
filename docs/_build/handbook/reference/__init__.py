"""The reference, made from the program: what can be written, asked and read."""
