"""A forecast as a record under the keys of the contract: saved in the ledger, and printed by `--json`."""

from typing import Any

from fieldkit.forecast.prediction import Prediction, median


def apogee_summary(prediction: Prediction) -> dict[str, float]:
    """Mean, standard deviation and quantiles of the apogee on the altimeter, under the contract's keys. [m]"""
    p05, p50, p95 = prediction.apogee_quantiles()
    return {
        "mean": float(prediction.apogee.mean()),
        "sd": float(prediction.apogee.std()),
        "p05": p05,
        "p50": p50,
        "p95": p95,
    }


def forecast_record(prediction: Prediction) -> dict[str, Any]:
    """A prediction under the contract's keys, with its basis."""
    document: dict[str, Any] = {"flight_id": prediction.plan.flight_id} if prediction.plan.flight_id else {}
    document |= {
        "rocket": prediction.plan.rocket,
        "config": prediction.plan.config,
        "motor": prediction.plan.motor,
        "apogee_m": apogee_summary(prediction),
        "true_apogee_m": median(prediction.true_apogee),
        "ejection_s": prediction.median_eject,
        "coast_s": median(prediction.coast),
        "top_speed_mps": median(prediction.top_speed),
        "rail_speed_mps": median(prediction.rail_speed),
        "cd": {"mean": float(prediction.cd.mean()), "sd": float(prediction.cd.std())},
        "alpha": {"mean": float(prediction.alpha.mean()), "sd": float(prediction.alpha.std())},
        "flights": prediction.rests_on,
        "model": prediction.model,
        "left_out": list(prediction.left_out),
        "interval": {
            "stretched_by": prediction.stretched_by,
            "earlier_forecasts": prediction.earlier_forecasts,
            "mixed_with": dict(prediction.mixed_with),
            "narrowed_by_flights": {str(more): prediction.narrowed(more) for more in (1, 3, 10)},
        },
    }
    return document
