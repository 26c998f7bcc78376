"""A shop's saved list of motors in stock: what is sold out is left out, and what is unknown is named."""

from pathlib import Path

import pytest

from fieldkit.errors import UnknownMotor
from fieldkit.motors import catalogue
from fieldkit.motors.stock import read_stock
from tests.commands import Run

TABLE = """Product,SKU,Qty
AeroTech F24W-4,A-1,3
Estes C6-5,E-2,0
"Quest, a starter set",Q-3,2
AeroTech F39T-6,A-4,sold out
E12-6,E-5,12
"""


def names(text: str) -> list[str]:
    return [f"{one.maker} {one.designation}" for one in read_stock(text, catalogue(), "stock.csv").motors]


def test_a_table_gives_the_motors_that_are_in_stock() -> None:
    found = read_stock(TABLE, catalogue(), "stock.csv")
    assert [one.designation for one in found.motors] == ["F24W", "E12"]
    assert [number for number, _ in found.unread] == [4]


def test_a_list_of_one_motor_in_each_line_is_read_too() -> None:
    assert names("# from the shop\nF24-4W\n\nEstes C6-5\nEstes C6-5\n") == ["AeroTech F24W", "Estes C6"]
    assert names("maker;motor;in stock\nEstes;Estes C6-5;yes\nEstes;Estes D12-5;out of stock\n") == ["Estes C6"]


def test_a_motor_is_found_in_the_name_of_a_product() -> None:
    products = ("Estes C6-5 (3 pack)", "AeroTech F39-6T RMS-24/40 Reload", "Quest Q-Jet C12-6FJ (2-pack)", "Tube BT-60")
    assert names("product,qty\n" + "".join(f"{one},2\n" for one in products)) == [
        "Estes C6",
        "AeroTech F39T",
        "Quest C12",
    ]


def test_a_file_without_a_motor_is_named() -> None:
    with pytest.raises(UnknownMotor, match=r"stock\.csv: found no motor of the catalog"):
        read_stock("name,price\nGlue,3\n", catalogue(), "stock.csv")


def test_the_guide_forecasts_only_what_is_in_stock(run: Run, tmp_path: Path) -> None:
    (tmp_path / "stock.csv").write_text(TABLE)
    done = run(
        "motors", "--fit", "Big", "--dry-mass", "300g", "--diameter", "66mm", "--mount", "29mm", "--adapter",
        "--in-stock", tmp_path / "stock.csv", "--json",
    )  # fmt: skip
    assert sorted(one["motor"] for one in done.document["motors"]) == ["E12", "F24W"]
    assert "stock.csv, row 4: no motor of the catalog" in done.err
