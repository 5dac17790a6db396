"""Arguments that a shell leaves empty, and names of tables that promise another format."""

import pytest


@pytest.mark.parametrize("command", ["read", "walker trajectory", "scooter angles"])
def test_an_empty_argument_is_not_the_current_folder(fails, command):
    fails(*command.split(), "", says=["an argument is empty"])


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["--geometry", "", "-o", "a.csv"], "--geometry"),
        (["--geometry=", "-o", "a.csv"], "--geometry"),
        (["--geometry", "g.toml", "-o", ""], "--output"),
        (["--geometry", "g.toml", "--output="], "--output"),
    ],
)
def test_an_empty_option_is_named(fails, arguments, name):
    fails("scooter", "angles", "ride.csv", *arguments, says=[f" {name}: the name is empty"])


@pytest.mark.parametrize("ending", ["xlsx", "parquet", "MAT"])
@pytest.mark.parametrize(
    "command",
    [
        "scooter angles r.csv --geometry g.toml -o",
        "scooter check r.csv --geometry g.toml --poses p.csv -o",
        "wheelchair tasks v.csv -o",
        "wheelchair tasks v.csv -o k.csv --events",
        "walker trajectory w.csv --geometry f.toml -o p.csv --steps",
        "read r.csv -o",
    ],
)
def test_a_table_is_no_workbook(fails, command, ending):
    fails(*command.split(), f"t.{ending}", says=["tables are written as CSV", ".csv.gz"])
