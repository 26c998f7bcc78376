"""What `export` writes, and where the ledger is."""

from pathlib import Path

from tests.commands import Run


def test_no_csv_table_is_written_under_the_name_of_a_workbook(run: Run, tmp_path: Path) -> None:
    assert "found .xlsx, expected .csv" in run("export", tmp_path / "flights.xlsx", status=1).err
    assert not (tmp_path / "flights.xlsx").exists()
    run("export", tmp_path / "flights.xlsx", "--format", "csv")


def test_the_list_of_backups_names_the_ledger(run: Run, tmp_path: Path) -> None:
    run("import", "--example")
    run("tag", "1", "mine")
    assert f"{tmp_path / 'ledger.db'}" in run("backups").err
