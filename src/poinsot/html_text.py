"""Results in a notebook: the text of a result, escaped."""

from __future__ import annotations

import html

__all__ = ["ShownInNotebooks"]


class ShownInNotebooks:
    """What is shown in a notebook as its `repr`, in which texts that come from files are no markup."""

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"
