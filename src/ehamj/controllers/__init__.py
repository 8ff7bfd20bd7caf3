"""Digital controllers: any discrete linear law from named channels to the four valve commands."""

from ehamj.controllers.law import Controller

__all__ = ["Controller"]
