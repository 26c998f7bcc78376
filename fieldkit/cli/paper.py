"""`fieldkit paper`: the reference flights, next to what the paper published about them."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.screen import print_json, print_table, say, say_wrapped
from fieldkit.cli.studies import need_studies

if TYPE_CHECKING:
    from studies.paper.report import PaperReport

app = typer.Typer()


@app.command()
def paper(json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Test the reference paper on its own twelve flights."""
    need_studies()
    from studies.paper.report import report
    from studies.paper.text import findings

    found = report()
    if json:
        print_json({**found.document(), "findings": findings(found)})
        return
    _flights(found)
    _histories(found)
    _errors(found)
    _synthetic(found)
    _rules(found)
    _say_findings(findings(found))


def _flights(report: "PaperReport") -> None:
    headers = ("flight", "motor", "apogee", "Cd", "publ.", "alpha", "publ.", "rebuilt", "publ.", "left out")
    say("Cd and alpha from the apogee [m], and the apogee rebuilt from them")
    say()
    print_table(headers, (_flight(one) for one in report.flights), numbers=headers[2:])
    say()
    say("publ.: published. left out: forecast from other valid flights on the same motor.")
    say("*: tagged as an anomaly, not counted below.")
    say()


def _flight(one: dict[str, Any]) -> tuple[str, ...]:
    pairs = (
        ("cd", "published_cd", ".3f"),
        ("alpha", "published_alpha", ".3f"),
        ("reconstructed_m", "published_apogee_m", ".1f"),
    )
    compared = [f"{one[key]:{form}}" for here, published, form in pairs for key in (here, published)]
    name = f"{one['flight_id']} {one['config']}{'' if one['valid'] else ' *'}"
    return (name, one["motor"], f"{one['apogee_m']:.1f}", *compared, f"{one['next_flight_m']:.1f}")


def _histories(report: "PaperReport") -> None:
    headers = ("flight", "motor", "apogee", "one apogee", "history", "90%", "Cd", "alpha")
    say("Each flight left out [m]: from one apogee at a time, and by the history network")
    say()
    print_table(headers, (_history(one) for one in report.flights), numbers=headers[2:])
    say()


def _history(one: dict[str, Any]) -> tuple[str, ...]:
    said = one["history_network"]
    low, middle, high = (said["apogee_m"][key] for key in ("p05", "p50", "p95"))
    name = f"{one['flight_id']} {one['config']}{'' if one['valid'] else ' *'}"
    figures = (f"{one['apogee_m']:.1f}", f"{one['next_flight_m']:.1f}", f"{middle:.1f}", f"{low:.0f} to {high:.0f}")
    return (name, one["motor"], *figures, f"{said['cd']:.3f}", f"{said['alpha']:.3f}")


def _errors(report: "PaperReport") -> None:
    stated = report.published["stated"]
    rows = [
        ("rebuilt, here", *_three(report.reconstruction)),
        ("rebuilt, published", *_three(report.published["reconstruction"])),
        ("next flight, left out, here", *_three(report.next_flight)),
        ("left out, by the history network", *_three(report.history_network)),
        ("OpenRocket column, recomputed", *_three(report.openrocket)),
        ("OpenRocket, as stated", f"{stated['openrocket_mae_m']}", f"{stated['openrocket_rmse_m']}", ""),
    ]
    headers = (f"Errors on the {report.reconstruction['n']} valid flights [m]", "MAE", "RMSE", "bias")
    print_table(headers, rows, numbers=headers[1:])
    say()


def _three(errors: dict[str, float]) -> tuple[str, str, str]:
    return f"{errors['mae_m']:.1f}", f"{errors['rmse_m']:.1f}", f"{errors['bias_m']:+.1f}"


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


def _rules(report: "PaperReport") -> None:
    headers = ("Each valid flight forecast from the others [m]", "MAE", "±", "bias", "n")
    rows = [
        (
            rule["title"],
            f"{rule['mae_m']:.1f}",
            f"{rule['standard_error_m']:.1f}",
            f"{rule['bias_m']:+.1f}",
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
