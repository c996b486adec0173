"""Contracts that authors of plug-ins inherit in their tests."""

from nhtrack.testing.law import LawContract

__all__ = ["LawContract"]
