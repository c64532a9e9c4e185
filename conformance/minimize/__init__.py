"""Shrinking a failing input by its structure while it still fails in the same way.

Rules: CNF-17. Edits change planes and call the writer (closed loop: what follows an edited plane is decoded anew), or
documents and their text; inputs that the reference rejects are shrunk as bits. Each smaller input is decoded by the
reference first, and the candidate is held against that.
"""

from .shrink import Budget, Minimized, minimize
from .target import Signature, Subject, Target, subject_of_file, subject_of_vector

__all__ = [
    "Budget",
    "Minimized",
    "Signature",
    "Subject",
    "Target",
    "minimize",
    "subject_of_file",
    "subject_of_vector",
]
