"""Fixtures for tests of the whole product."""

import pytest
from product import Product, build


@pytest.fixture(scope="session")
def fmus(request, tmp_path_factory) -> Product:
    """Both FMUs, built once.

    The product's cache for the tests stays in pytest's own cache directory: it is keyed
    by the sources' hashes, and keeps compiled code for the next session.
    """
    kept = getattr(request.config, "cache", None)
    cache = kept.mkdir("rail-cosim") if kept else tmp_path_factory.mktemp("cache")
    return build(tmp_path_factory.mktemp("fmus"), cache)
