"""The scorecard on the command line."""

import json


def test_reproduce_on_the_terminal_and_as_json(works):
    table = works("reproduce", "--work", "walker")
    assert "9.6525" in table.stdout and "differs" in table.stdout
    records = json.loads(works("reproduce", "--work", "walker", "--json").stdout)
    wrong = {r["where"] for r in records if r["verdict"] == "differs"}
    # Which ones differ is held by test_walker_audit.py; here, that the command says the same.
    from mobility_imu.reproduction.scorecard import scorecard

    assert wrong == {o.claim.where for o in scorecard("walker") if o.verdict == "differs"}
    for record in records:
        assert (record["tolerance"] is None) == (record["tolerance_reason"] is None)
