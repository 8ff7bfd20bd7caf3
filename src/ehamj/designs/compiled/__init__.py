"""Compiled closed forms of many designs: one design after the other, so that none depends on those beside it."""
