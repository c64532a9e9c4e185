"""Which version runs, and in which form.

Rules: none of the register; the provenance of vectors and reports quotes it.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version


def version_number() -> str:
    """The version of the installed distribution; of a checkout that was never installed, `unknown`."""
    try:
        return version("snhc")
    except PackageNotFoundError:
        return "unknown"


def form() -> str:
    """`pure`, or `compiled` where the kernels are extension modules."""
    from snhc.reference_impl.entropy import kernel

    return "pure" if str(kernel.__file__).endswith((".py", ".pyc")) else "compiled"


def version_line() -> str:
    """`snhc 0.1.0 (pure)`."""
    return f"snhc {version_number()} ({form()})"
