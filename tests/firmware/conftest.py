"""The C device, built once; assertions in the scenarios explain themselves."""

import shutil

import pytest

from sim_backend.firmware import BenchLibrary, build_library

pytest.register_assert_rewrite("tests.device.guard_scenarios")


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> BenchLibrary:
    if shutil.which("cc") is None and shutil.which("gcc") is None:
        pytest.skip("needs a C compiler (apt install gcc)")
    return BenchLibrary(build_library(tmp_path_factory.mktemp("library")))
