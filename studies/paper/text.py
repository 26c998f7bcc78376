"""The meaning of the report's figures in words."""

from typing import Any

from studies.paper.report import PaperReport


def findings(report: PaperReport) -> list[str]:
    """Five findings for a reader of the paper, one paragraph each."""
    return [_reconstruction(report), _openrocket(report), _thrust(report), _limit(report), _floor(report)]


def _reconstruction(report: PaperReport) -> str:
    carried = _rule(report, "published_carried_over")
    published = report.published["reconstruction"]
    return (
        "The published apogee errors are reconstructions: Cd and alpha are inferred from the very apogee that is "
        "then predicted. Leave the flight out, carry Cd and alpha over from the same motor's other flights, "
        f"and the mean error is {carried['mae_m']:.1f} m with the published parameters, not "
        f"{published['mae_m']:.1f} m, and {report.next_flight['mae_m']:.1f} m with those found here, not "
        f"{report.reconstruction['mae_m']:.1f} m."
    )


def _openrocket(report: PaperReport) -> str:
    own, stated = report.openrocket, report.published["stated"]
    return (
        f"The paper's OpenRocket column misses the {own['n']} valid flights by {own['mae_m']:.1f} m in the mean "
        f"(RMSE {own['rmse_m']:.1f} m) by its own numbers. The paper states {stated['openrocket_mae_m']} m "
        f"and {stated['openrocket_rmse_m']} m."
    )


def _thrust(report: PaperReport) -> str:
    profile = report.thrust_profile
    motors, bias = profile["motors"], profile["exact_posterior_bias_m"]
    delivered, certified = (_list([f"{m[key]:.1f}" for m in motors]) for key in ("delivered_ns", "certified_ns"))
    return (
        f"The published thrust profile delivers {delivered} N s where the certificates say {certified}. So "
        f"{profile['below_lowest_apogee_of_prior']['published']} of the {report.reconstruction['n']} valid flights "
        "lie below the lowest apogee that the prior can produce. That alone makes the bias: the exact posterior, "
        f"with no network in it, is {bias['published']:+.1f} m off with this profile, "
        f"{bias['impulse_normalised']:+.1f} m with the same profile scaled to the right impulse, "
        f"{bias['certified']:+.1f} m with certified curves and {bias['certified_with_casing']:+.1f} m with the "
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
    return (
        "Forecasts of flights that were left out are above. Flights of one motor and configuration scatter by "
        f"{scatter['sd_m']:.1f} m ({scatter['degrees_of_freedom']} degrees of freedom): even a forecast that knew "
        f"their mean would miss by {scatter['perfect_mae_m']:.1f} m on average, and the mean of two earlier flights "
        f"by {scatter['two_peers_mae_m']:.1f} m. With a standard error of {min(fitted):.0f} to {max(fitted):.0f} m "
        "on so few flights, the rules that are fitted to flights can hardly be distinguished."
    )


def _rule(report: PaperReport, key: str) -> dict[str, Any]:
    return next(rule for rule in report.rules if rule["rule"] == key)


def _list(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}"
