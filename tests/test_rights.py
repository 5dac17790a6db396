"""Files that may not be read or written, tried as somebody without a superuser's rights."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
NEEDING_RIGHTS = (
    "cli/test_cli_outputs.py::TestRights",
    "readers/test_damaged_files.py::test_files_that_may_not_be_read",
)
WITHOUT = "--bounding-set=-dac_override,-dac_read_search"


@pytest.mark.skipif(
    os.geteuid() == 0 and not shutil.which("setpriv"),
    reason="a superuser, and no setpriv to give rights up",
)
def test_rights_are_respected():
    """A superuser gives up the right to pass over rights; anybody else has none to give up."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    command += [str(TESTS / name) for name in NEEDING_RIGHTS]
    if os.geteuid() == 0:
        command = ["setpriv", WITHOUT, *command]
    # Plugins that these tests do without take longer to load than the tests run.
    environment = {
        **os.environ,
        "RIGHTS_GIVEN_UP": "1",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    out = subprocess.run(command, capture_output=True, text=True, cwd=TESTS.parent, env=environment)
    assert re.search(r"^3 passed in", out.stdout, re.MULTILINE), out.stdout + out.stderr
