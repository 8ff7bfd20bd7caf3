"""Courses of what moves on the machine: where a slide stands at each time."""
