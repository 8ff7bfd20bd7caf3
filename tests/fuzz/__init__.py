"""Inputs by the thousand before the command line: `make fuzz`, see CONTRIBUTING."""
