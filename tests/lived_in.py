"""A home as flyers have one: mappings of columns, a draft, US units, a theme, a box of motors, kits and a motor file.

None of it may change what a command answers as JSON, which is in SI, or make one fail.
"""

from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.paths import HOME, data_file
from fieldkit.settings import change_settings

KITS = '["Big Bertha"]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n'
MOTOR = "X9 24 70 4-6 0.02 0.05 ACME\n0.1 12\n0.9 8\n1.1 0\n;\n"


def move_in(folder: Path, patch: pytest.MonkeyPatch) -> Path:
    """Furnish the home in a folder, from here on the user's own; its ledger is another one than that of a test."""
    home = folder / "home"
    patch.setenv(HOME, str(home))
    ledger = ["--ledger", str(folder / "of_the_home.db")]
    table = folder / "odd.csv"
    table.write_text("when,how high,craft\n2025-05-01T10:00,250,Law\n")
    mapping = ["apogee=how high [m]", "rocket=craft", "date_time=when"]
    assert main([*ledger, "import", str(table), *(part for one in mapping for part in ("--map", one))]) == 0
    table.write_text("tick,up\n" + "".join(f"{n / 10},{max(0, n - 20)}\n" for n in range(100)))
    main([*ledger, "inspect", str(table), "--map", "time=tick [s]", "--map", "altitude=up [ft]"])
    motors = data_file("motors")
    motors.mkdir(parents=True)
    (motors / "own.eng").write_text(MOTOR)
    data_file("kits.toml").write_text(KITS)
    assert main([*ledger, "flyer", "--certification", "1"]) == 0
    change_settings({"units": "US", "theme": "night"})
    return home
