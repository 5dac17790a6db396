"""Arguments that a shell leaves empty."""

import pytest


@pytest.mark.parametrize("command", ["read", "walker trajectory", "scooter angles"])
def test_an_empty_argument_is_not_the_current_folder(fails, command):
    fails(*command.split(), "", says=["an argument is empty"])
