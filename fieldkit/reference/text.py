"""The meaning of the report's figures in words."""

from typing import Any

from fieldkit.messages import amount, message
from fieldkit.reference.report import PaperReport


def findings(report: PaperReport) -> list[str]:
    """Five findings for a reader of the paper, one paragraph each."""
    found = [_reconstruction(report), _openrocket(report), _thrust(report), _limit(report), _floor(report)]
    return [message(paragraph) for paragraph in found]


def _reconstruction(report: PaperReport) -> str:
    carried, published = _rule(report, "published_carried_over"), report.published["reconstruction"]
    errors = (carried, published, report.next_flight, report.reconstruction)
    left_out, stated, here, rebuilt = (amount(one["mae_m"], "m", 1) for one in errors)
    return (
        "The published apogee errors are reconstructions: Cd and alpha are inferred from the very apogee that is "
        "then predicted. Leave the flight out, carry Cd and alpha over from the same motor's other flights, "
        f"and the mean error is {left_out} with the published parameters, not {stated}, and {here} with those found "
        f"here, not {rebuilt}."
    )


def _openrocket(report: PaperReport) -> str:
    own, stated = report.openrocket, report.published["stated"]
    mae, rmse = (amount(own[f"{key}_m"], "m", 1) for key in ("mae", "rmse"))
    stated_mae, stated_rmse = (amount(stated[f"openrocket_{key}_m"], "m", 1) for key in ("mae", "rmse"))
    return (
        f"The paper's OpenRocket column misses the {own['n']} valid flights by {mae} in the mean (RMSE {rmse}) by its "
        f"own numbers. The paper states {stated_mae} and {stated_rmse}."
    )


def _thrust(report: PaperReport) -> str:
    profile = report.thrust_profile
    motors, bias = profile["motors"], profile["exact_posterior_bias_m"]
    delivered, certified = (_list([f"{m[key]:.1f}" for m in motors]) for key in ("delivered_ns", "certified_ns"))
    return (
        f"The published thrust profile delivers {delivered} N s where the certificates say {certified}. So "
        f"{profile['below_lowest_apogee_of_prior']['published']} of the {report.reconstruction['n']} valid flights "
        "lie below the lowest apogee that the prior can produce. That alone makes the bias: the exact posterior, "
        f"with no network in it, is {_off(bias['published'])} off with this profile, "
        f"{_off(bias['impulse_normalised'])} with the same profile scaled to the right impulse, "
        f"{_off(bias['certified'])} with certified curves and {_off(bias['certified_with_casing'])} with the "
        "casing's mass as well. Below that lowest apogee a network can only extrapolate: train it with another "
        "seed, and the reconstructions change while the errors on simulated flights stay the same."
    )


def _limit(report: PaperReport) -> str:
    limit, found, stated = report.bayes_limit, report.synthetic, report.published["stated"]
    return (
        "An apogee alone cannot separate drag from thrust. No method gets below a mean error of "
        f"{limit['cd_mae']:.4f} for Cd and {limit['alpha_mae']:.4f} for alpha on these simulated flights; the "
        f"published {stated['cd_mae']} and {stated['alpha_mae']} already reach that limit. Nor is the spread of the "
        "ensemble an uncertainty: the true Cd is within one standard deviation of it on "
        f"{found['cd_coverage_one_sd']:.0%} of the flights and the true alpha on {found['alpha_coverage_one_sd']:.0%}; "
        "68% would be right."
    )


def _floor(report: PaperReport) -> str:
    scatter = report.scatter
    fitted = [rule["standard_error_m"] for rule in report.rules if not rule["rule"].startswith("nominal")]
    spread, perfect, peers = (amount(scatter[key], "m", 1) for key in ("sd_m", "perfect_mae_m", "two_peers_mae_m"))
    return (
        "Forecasts of flights that were left out are above. Flights of one motor and configuration scatter by "
        f"{spread} ({scatter['degrees_of_freedom']} degrees of freedom): even a forecast that knew their mean would "
        f"miss by {perfect} on average, and the mean of two earlier flights by {peers}. With a standard error of "
        f"{amount(min(fitted), 'm', to=max(fitted))} on so few flights, the rules that are fitted to flights can "
        "hardly be distinguished."
    )


def _off(bias: float) -> str:
    """A bias [m] with its sign."""
    return f"{'+' if bias >= 0 else ''}{amount(bias, 'm', 1)}"


def _rule(report: PaperReport, key: str) -> dict[str, Any]:
    return next(rule for rule in report.rules if rule["rule"] == key)


def _list(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}"
