"""Mechanisms under test: reference cases of ``references/``, chains and ladders of any size, random ones."""

from validation.cases.reference import Case, build, load, names, read
