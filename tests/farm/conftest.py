"""Workers for tests to share, as ``dask worker`` starts them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module")
def address(request: pytest.FixtureRequest) -> Iterator[str]:
    """The scheduler of two workers, which know the classes of the test module."""
    import cloudpickle
    import dask
    import distributed

    cloudpickle.register_pickle_by_value(request.module)
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        # After 15 s a cluster ends what restarts a worker; under load that takes longer.
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1 day"}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", memory_limit=None
        ) as cluster,
    ):
        yield cluster.scheduler_address
    cloudpickle.unregister_pickle_by_value(request.module)
