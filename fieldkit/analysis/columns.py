"""Convert the measurements to the fields of a flight: readouts, their standard deviations, and their sensors."""

from collections.abc import Mapping

from fieldkit import units
from fieldkit.analysis.channels import sensor
from fieldkit.analysis.notes import NO_FLIGHT
from fieldkit.analysis.records import Figure, Recorded
from fieldkit.errors import BadValue
from fieldkit.flight import MEASURED, TWO_DEVICES, Column
from fieldkit.flight.limits import check


def columns(recorded: Recorded, stated: Mapping[str, object]) -> tuple[dict[str, object], dict[str, str]]:
    """Fields of a flight and its extra columns, from the measurements and what the device stated.

    The measured figure is the readout, because its uncertainty is known and a device may state a spike as the apogee;
    the stated figure is stored in an extra column. If the samples do not show a figure, such as the apogee of a log
    that ends before it, the stated figure is the readout. If the log contains no flight, stated figures are not trusted
    either. Standard deviations are rounded to two digits.
    """
    fields = dict(stated)
    extra: dict[str, str] = {}
    sd: dict[str, float] = {}
    source: dict[str, str] = {}
    for column in MEASURED:
        value, figure = stated.get(column.name), recorded.figures.get(column.name)
        if isinstance(value, float):
            extra[column.stated_header] = column.render(value)
            source[column.name] = "stated"
            if NO_FLIGHT in recorded.notes:
                del fields[column.name], source[column.name]
        if figure and _possible(column, figure):
            fields[column.name] = round(figure.value, 7 if column.quantity == "per length" else 3)
            source[column.name] = sensor(figure.source)
            scale = units.unit(column.quantity, column.unit)
            if rounded := float(f"{scale.difference_from_si(figure.sd):.2g}"):
                sd[column.name] = scale.difference_to_si(rounded)
    fields |= {name: known for name, known in (("sd", sd), ("source", source)) if known}
    if top := recorded.figures.get("time_to_apogee"):
        extra |= {"time_to_apogee_s": f"{top.value:.3f}", "time_to_apogee_sd_s": f"{top.sd:.2g}"}
    for column in TWO_DEVICES:
        if figure := recorded.figures.get(column.name):
            extra |= {column.header: f"{figure.value:.3f}", column.sd_header: f"{figure.sd:.2g}"}
    return fields, extra


def _possible(column: Column, figure: Figure) -> bool:
    try:
        check(column, figure.value)
    except BadValue:
        return False
    return True
