"""Figures of merit of a machine by name: what studies of many designs compute, compare and bound."""
