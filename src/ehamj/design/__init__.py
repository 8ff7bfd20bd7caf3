"""Synthesis of controllers for a machine: gains under stated margins, budgets, and laws from models."""
