"""A scenario, a result or a design in the forms that other tools take."""
