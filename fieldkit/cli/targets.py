"""Output files: an existing file is replaced only with the user's consent or `--force`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from fieldkit.files import check_target, is_taken

ForceOption = Annotated[bool, typer.Option("--force", help="Replace an existing file.")]


def settled(file: Path, force: bool) -> bool:
    """Whether a file may be replaced: `force` decides; otherwise the user is asked if the file exists and a person is
    at the terminal. Called before the work whose result is written. Raises FieldkitError for a file that must not be
    written."""
    asks = is_taken(file) and not force and sys.stdin.isatty() and sys.stderr.isatty()
    check_target(file, force=force or asks)
    if asks:
        typer.confirm(f"{file} already exists. Replace it?", abort=True, err=True)
    return force or asks
