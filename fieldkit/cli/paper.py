"""`fieldkit paper`: the reference flights, next to what the paper published about them."""

from typing import TYPE_CHECKING, Any

import typer

from fieldkit.cli.screen import AsJson, print_json, print_table, say, say_wrapped, system
from fieldkit.quantities import ShownUnits, in_system

if TYPE_CHECKING:
    from fieldkit.reference.report import PaperReport

app = typer.Typer()


@app.command()
def paper(json: AsJson = False) -> None:
    """Test the reference paper on its own twelve flights."""
    from fieldkit.reference.report import report
    from fieldkit.reference.text import findings

    found = report()
    if json:
        print_json({**found.document(), "findings": findings(found)})
        return
    units = ShownUnits(system())
    _flights(found, units)
    _passes(found, units)
    _errors(found, units)
    _synthetic(found)
    _rules(found, units)
    _say_findings([in_system(paragraph, units.system) for paragraph in findings(found)])


def _flights(report: "PaperReport", units: "ShownUnits") -> None:
    headers = ("flight", "motor", "apogee", "Cd", "publ.", "alpha", "publ.", "rebuilt", "publ.", "left out")
    say(f"Cd and alpha from the apogee [{units.length_unit}], and the apogee rebuilt from them")
    say()
    print_table(headers, (_flight(one, units) for one in report.flights), numbers=headers[2:])
    say()
    say("publ.: published. left out: forecast from other valid flights on the same motor.")
    say("*: tagged as an anomaly, not counted below.")
    say()


def _flight(one: dict[str, Any], units: "ShownUnits") -> tuple[str, ...]:
    fitted = [f"{one[key]:.3f}" for key in ("cd", "published_cd", "alpha", "published_alpha")]
    heights = ("apogee_m", "reconstructed_m", "published_apogee_m", "next_flight_m")
    apogee, *others = [_length(units, one[key]) for key in heights]
    name = f"{one['flight_id']} {one['config']}{'' if one['valid'] else ' *'}"
    return (name, one["motor"], apogee, *fitted, *others)


def _length(units: "ShownUnits", value: float) -> str:
    """A length [m] in the user's units, without the unit, which the heading states."""
    return units.length(value, 1).split()[0]


def _signed(units: "ShownUnits", value: float) -> str:
    """A difference of two lengths [m] in the user's units, without the unit."""
    return units.difference(value).split()[0]


def _passes(report: "PaperReport", units: "ShownUnits") -> None:
    headers = ("flight", "motor", "apogee", "one apogee", "linear pass", "90%", "Cd", "alpha")
    say(f"Each left out [{units.length_unit}]: from one apogee at a time, and by a linear pass")
    say()
    print_table(headers, (_pass_row(one, units) for one in report.flights), numbers=headers[2:])
    say()


def _pass_row(one: dict[str, Any], units: "ShownUnits") -> tuple[str, ...]:
    forecast = one["linear_pass"]
    apogees = [one["apogee_m"], one["next_flight_m"], forecast["apogee_m"]["p50"]]
    interval = units.lengths(*(forecast["apogee_m"][key] for key in ("p05", "p95"))).rpartition(" ")[0]
    name = f"{one['flight_id']} {one['config']}{'' if one['valid'] else ' *'}"
    figures = [_length(units, apogee) for apogee in apogees]
    return (name, one["motor"], *figures, interval, f"{forecast['cd']:.3f}", f"{forecast['alpha']:.3f}")


def _errors(report: "PaperReport", units: "ShownUnits") -> None:
    stated = report.published["stated"]
    rows = [
        ("rebuilt, here", *_three(report.reconstruction, units)),
        ("rebuilt, published", *_three(report.published["reconstruction"], units)),
        ("next flight, left out, here", *_three(report.next_flight, units)),
        ("left out, by a linear pass", *_three(report.linear_pass, units)),
        ("OpenRocket column, recomputed", *_three(report.openrocket, units)),
        ("OpenRocket, as stated", *(_length(units, stated[f"openrocket_{key}_m"]) for key in ("mae", "rmse")), ""),
    ]
    headers = (f"Errors on the {report.reconstruction['n']} valid flights [{units.length_unit}]", "MAE", "RMSE", "bias")
    print_table(headers, rows, numbers=headers[1:])
    say()


def _three(errors: dict[str, float], units: "ShownUnits") -> tuple[str, str, str]:
    mae, rmse = (_length(units, errors[key]) for key in ("mae_m", "rmse_m"))
    return mae, rmse, _signed(units, errors["bias_m"])


def _synthetic(report: "PaperReport") -> None:
    stated, found, limit = report.published["stated"], report.synthetic, report.bayes_limit
    rows = [
        (
            title,
            f"{found[f'{name}_mae']:.4f}",
            f"{found[f'{name}_standard_error']:.4f}",
            f"{stated[f'{name}_mae']:.3f}",
            f"{limit[f'{name}_mae']:.4f}",
            f"{found[f'{name}_coverage_one_sd']:.0%}",
        )
        for name, title in (("cd", "Cd"), ("alpha", "alpha"))
    ]
    headers = (f"MAE on {found['n']} simulated flights", "here", "±", "published", "possible", "within 1 sd")
    print_table(headers, rows, numbers=headers[1:])
    say()


def _rules(report: "PaperReport", units: "ShownUnits") -> None:
    headers = (f"Each valid flight forecast from the others [{units.length_unit}]", "MAE", "±", "bias", "n")
    rows = [
        (
            rule["title"],
            _length(units, rule["mae_m"]),
            _length(units, rule["standard_error_m"]),
            _signed(units, rule["bias_m"]),
            str(rule["n"]),
        )
        for rule in report.rules
    ]
    print_table(headers, rows, numbers=headers[1:])
    say()
    say("±: standard error. How each forecast is made: fieldkit paper --json.")
    say()


def _say_findings(paragraphs: list[str]) -> None:
    for number, paragraph in enumerate(paragraphs, start=1):
        say_wrapped(f"{number}. {paragraph}", "   ")
        say()
