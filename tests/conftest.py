"""Which tests share a worker: those of a file, since they share what a file prepares, and all of the founding lift."""

from __future__ import annotations

import pytest

ONE_RUN = "turnover"  # the folder whose tests read one and the same run


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("xdist_group"):
            continue  # large matrices say themselves how they are shared out
        group = ONE_RUN if item.path.parent.name == ONE_RUN else str(item.path)
        item.add_marker(pytest.mark.xdist_group(group))
