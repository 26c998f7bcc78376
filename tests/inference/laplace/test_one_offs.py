"""Flights that differ from their rocket: found, named by what they show, and without influence on its forecasts."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import forecast_model
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.one_offs import OneOffs, _LeftOut, _Likelihood, _precisions, one_offs
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.model.causes import CAUSES, NAMES, OTHER_PEAK_SD, signatures
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of
from fieldkit.physics.logged import highest_mean
from fieldkit.shapes import Array
from fieldkit.units import STANDARD_GRAVITY

pytestmark = pytest.mark.fast

Flown = list[tuple[Flight, Found]]
MOTOR = catalogue().resolve("F24-7W")
READOUTS = ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject")
NOISE = {"apogee": 0.02, "top_speed": 0.02, "burn_time": 0.02, "peak_accel": 0.05, "coast_to_apogee": 0.02}


def season(
    bends: Mapping[int, Mapping[str, float]] | None = None, names: tuple[str, ...] = READOUTS, count: int = 8
) -> Flown:
    """Flights of one rocket with scatter; `bends` are the properties that differ on some of them."""
    rng = np.random.default_rng(5)
    plans = [
        Flight(f"{i}", "Law", "A", "F24-7W", dry_mass=0.322, diameter=0.066, rail_length=1.2) for i in range(count)
    ]
    model = forecast_model(history_of(plans, [MOTOR] * count))
    scatter: dict[str, Array] = {
        name: np.zeros((1, count)) for name in ("thrust", "drag", "stretch", "delay", "mass", "tilt")
    }
    for row, own in (bends or {}).items():
        for name, amount in own.items():
            scatter[name][0, row] = amount
    readings = shown(model, np.array([[term.mean for term in model.terms]]), scatter)
    rows = []
    for i, plan in enumerate(plans):
        noisy = {name: float(readings[name][0, i] * np.exp(NOISE.get(name, 0.0) * rng.normal())) for name in READOUTS}
        rows.append((plan.with_changes(**{name: noisy[name] for name in names}), MOTOR))
    return rows


def fitted(flown: Flown) -> Fit:
    flights, found = [flight for flight, _ in flown], [motor for _, motor in flown]
    history = history_of(flights, found, used_in_fit=[True] * len(flown))
    model = replace(forecast_model(history), coarse=True)
    return fit_robustly(model, observe(history, model.hyperprior), causes=True)


def judged(flown: Flown) -> OneOffs:
    return one_offs(fitted(flown))


def likeliest(found: OneOffs, row: int) -> str:
    return NAMES[int(np.argmax(found.cause[row]))]


def next_apogee(flown: Flown) -> float:
    plan = flown[0][0].unflown(flight_id="")
    (made,) = predict(flown, [(plan, MOTOR)])
    return made.apogee_quantiles()[1]


def test_probabilities_of_a_flight_add_to_one() -> None:
    found = judged(season({3: {"tilt": 20.0}}))
    assert found.normal + found.cause.sum(axis=1) == pytest.approx(1.0)


def test_usual_flights_are_not_singled_out() -> None:
    assert judged(season()).normal.min() > 0.8


@pytest.mark.parametrize(
    ("bends", "cause"),
    [
        ({"thrust": -0.35}, "weak_motor"),
        ({"drag": 1.2}, "extra_drag"),
        ({"tilt": 49.0}, "arc"),  # 35 degrees
        ({"delay": -1.0}, "early_ejection"),
    ],
)
def test_a_faulty_flight_is_named_by_what_its_readouts_show(bends: Mapping[str, float], cause: str) -> None:
    found = judged(season({5: bends}))
    assert found.normal[5] < 0.2
    assert likeliest(found, 5) == cause
    assert np.delete(found.normal, 5).min() > 0.7


def test_a_misread_speed_is_a_misread_speed() -> None:
    flown = season()
    flight = flown[2][0]
    assert flight.top_speed is not None
    flown[2] = (flight.with_changes(top_speed=flight.top_speed * 1.609), MOTOR)  # miles read as kilometers
    found = judged(flown)
    assert found.normal[2] < 0.2
    assert likeliest(found, 2) == "misread"
    assert found.strength[2, NAMES.index("misread")] == pytest.approx(np.log(1.609), abs=0.15)


def landed(flight: Flight, apogee: float) -> Flight:
    """A flight that fell to its ejection and came down at 5 m/s, from this height [m]."""
    late = flight.apogee_to_eject or 0.0
    rise = (flight.burn_time or 0.0) + (flight.coast_to_apogee or 0.0) + late
    sinking = (apogee - STANDARD_GRAVITY / 2 * max(late, 0.0) ** 2) / 5.0
    return flight.with_changes(descent_speed=5.0, duration=rise + sinking)


@pytest.mark.parametrize("names", [("apogee",), ("apogee", "burn_time", "coast_to_apogee")])
def test_the_way_down_distinguishes_a_low_flight_and_a_misread_apogee(names: tuple[str, ...]) -> None:
    flown = season({5: {"thrust": -0.3}})
    times = ("burn_time", "coast_to_apogee", "apogee_to_eject")
    low, apogee = flown[5][0], flown[5][0].apogee or 0.0

    def misread(flight: Flight) -> float:
        kept = {name: flight.number(name) for name in (*names, *times, "descent_speed", "duration")}
        rows = [(one.unflown(**{name: one.number(name) for name in names}), motor) for one, motor in flown]
        rows[5] = (flight.unflown(**kept), MOTOR)
        return float(judged(rows).cause[5, NAMES.index("misread")])

    unknown, agrees, differs = (misread(one) for one in (low, landed(low, apogee), landed(low, 1.6 * apogee)))
    assert agrees < 0.5 * unknown
    assert differs > 2.0 * unknown


def test_with_the_apogee_alone_several_causes_remain_possible() -> None:
    found = judged(season({5: {"drag": 1.6}}, names=("apogee",)))
    assert found.normal[5] < 0.2
    assert np.sort(found.cause[5])[-1] < 0.6


def test_one_bad_flight_does_not_move_the_next_forecast() -> None:
    right, bad = season(names=("apogee",), count=10), season({6: {"tilt": 100.0}}, names=("apogee",), count=10)
    assert bad[6][0].apogee < 0.7 * right[6][0].apogee  # type: ignore[operator]
    assert next_apogee(bad) == pytest.approx(next_apogee(right), rel=0.02)


def test_two_bad_flights_of_seven_do_not_hide_each_other() -> None:
    found = judged(season({1: {"tilt": 64.0}, 4: {"thrust": -0.5}}, count=7))
    assert (found.normal[[1, 4]] < 0.5).all()
    assert np.delete(found.normal, [1, 4]).min() > 0.6


@pytest.mark.parametrize(("first", "names"), [(5, READOUTS), (7, READOUTS), (7, ("apogee",))], ids=str)
def test_what_lasts_is_not_a_one_off_and_moves_the_forecast(first: int, names: tuple[str, ...]) -> None:
    flown = season({row: {"drag": 0.8} for row in range(first, 10)}, names, count=10)
    assert judged(flown).normal.min() > 0.5
    before, latest = (np.mean([flight.apogee for flight, _ in some]) for some in (flown[:first], flown[first:]))
    assert abs(next_apogee(flown) - latest) < 0.4 * abs(before - latest)


def test_the_prediction_without_a_flight_is_that_of_a_fit_without_it() -> None:
    """Woodbury's identity: exact at one point of linearization."""
    whole = fitted(season())
    seen = whole.data.seen.copy()
    seen[3] = False
    without = solve(whole.model, replace(whole.data, seen=seen), whole.tangent)
    assert one_offs(without, whole.data).miss[3] == pytest.approx(one_offs(whole).miss[3], abs=2e-3, nan_ok=True)


def test_a_flight_of_no_weight_has_no_influence() -> None:
    whole = fitted(season())
    seen, normal = whole.data.seen.copy(), np.ones(8)
    seen[3], normal[3] = False, 1e-9
    without = solve(whole.model, replace(whole.data, seen=seen), whole.tangent)
    weightless = solve(whole.model, replace(whole.data, normal=normal), whole.tangent)
    assert weightless.moments()[0] == pytest.approx(without.moments()[0], abs=1e-4)


@pytest.mark.parametrize("name", ["weak_motor", "extra_drag", "arc", "early_ejection"])
def test_what_goes_wrong_lowers_the_apogee_and_more_of_it_lowers_it_more(name: str) -> None:
    whole = fitted(season())
    known = signatures(whole.model, whole.tangent.at, whole.tangent.values, whole.data.seen)
    rows = np.flatnonzero((known.cause == NAMES.index(name)) & np.isfinite(known.log_prior[:, 0]))
    rows = rows[np.argsort(np.abs(known.strength[rows, 0]))]
    apogee = known.shift[rows, 0, 0]
    assert (apogee <= 0).all()
    assert apogee[-1] < -0.3
    assert (np.diff(apogee) < 1e-3).all()


def test_a_cause_that_moves_readouts_by_rounding_alone_does_not_show() -> None:
    """With apogees alone a late ejection changes nothing, whatever the last digits of two simulations."""
    whole = fitted(season())
    seen = whole.data.seen & (np.arange(whole.data.seen.shape[1]) == 0)
    possible = [
        np.isfinite(signatures(whole.model, whole.tangent.at, whole.tangent.values + off, seen).log_prior)
        for off in (0.0, 1e-13, -1e-13)
    ]
    np.testing.assert_array_equal(possible[1], possible[0])
    np.testing.assert_array_equal(possible[2], possible[0])
    assert possible[0].any()
    assert not possible[0].all()


def test_an_arc_leaves_the_top_speed_as_usual_and_shortens_the_coast() -> None:
    whole = fitted(season())
    known = signatures(whole.model, whole.tangent.at, whole.tangent.values, whole.data.seen)
    (row,) = np.flatnonzero((known.cause == NAMES.index("arc")) & (np.abs(known.strength[:, 0] - 21.0) < 1.0))
    speed, coast = (known.shift[row, 0, OBSERVED_READOUTS.index(name)] for name in ("top_speed", "coast_to_apogee"))
    assert abs(speed) < 0.03
    assert coast < -0.03


def test_priors_of_causes_add_up_on_a_flight_that_can_show_all() -> None:
    whole = fitted(season())
    known = signatures(whole.model, whole.tangent.at, whole.tangent.values, whole.data.seen)
    for name in ("weak_motor", "extra_drag", "mass", "misread"):
        prior = np.exp(known.log_prior[known.cause == NAMES.index(name), 0]).sum()
        assert prior == pytest.approx(CAUSES[name].prevalence, rel=0.05)


@pytest.mark.parametrize(("last", "changed"), [(1.28, (0.1, 0.9)), (1.0, (0.0, 0.02))])
def test_a_last_flight_far_off_may_be_the_first_of_a_changed_rocket(last: float, changed: tuple[float, float]) -> None:
    """The earlier flights then count for less, and its forecast covers both."""
    *before, (flight, motor) = season(names=("apogee",))
    assert flight.apogee is not None
    found = judged([*before, (flight.with_changes(apogee=last * flight.apogee), motor)])
    assert changed[0] <= found.changed <= changed[1]
    if last > 1:
        assert found.weight[:-1].max() == pytest.approx(1 - found.changed, rel=0.1)
        assert found.normal[-1] > found.changed


def test_another_motor_has_a_peak_of_its_own() -> None:
    """A quarter less impulse in a fifth more time, and a spike that the recorded motor does not have, in logs."""
    flown = season({3: {"thrust": -0.3, "stretch": 0.2}})
    flight, motor = flown[3]
    flown[3] = flight.with_changes(peak_accel=1.7 * (flight.peak_accel or 0.0)), motor
    logged = [
        (
            one.with_changes(
                sd={name: 0.02 * (one.number(name) or 0.0) for name in NOISE}, source=dict.fromkeys(NOISE, "accel")
            ),
            own,
        )
        for one, own in flown
    ]
    found = judged(logged)
    assert likeliest(found, 3) == "other_motor"
    assert found.cause[3].max() > 0.9


def test_peaks_of_motors_of_a_class_scatter_as_the_signatures_say() -> None:
    peaks: dict[str, list[float]] = {}
    for motor in catalogue().motors:
        peak = highest_mean(motor) * float(np.max(motor.thrust))
        first, last = motor.burning
        own = np.log(peak * (last - first) / motor.total_impulse)
        peaks.setdefault(motor.designation[0] if motor.designation[0].isalpha() else "", []).append(float(own))
    spread = np.sqrt(np.mean([np.var(some) for some in peaks.values() if len(some) > 5]))
    assert pytest.approx(np.sqrt(2) * spread, abs=0.03) == OTHER_PEAK_SD


def test_the_likelihood_of_a_shift_is_that_of_the_mixture_of_normal_distributions() -> None:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(2, 3, 2, 2))
    known, scatter = root[0] @ root[0].swapaxes(-1, -2), root[1] @ root[1].swapaxes(-1, -2)
    reading, log_weight = np.array([[0.5, 0.7]] * 3), np.log([0.5, 0.3, 0.2])
    predicted = _LeftOut(np.arange(3)[None], rng.normal(size=(1, 3, 2)), known[None], log_weight[None])
    (flight,) = _Likelihood.of(predicted, scatter[None], reading[None], 4.0)
    shift, spread = rng.normal(size=(2, 5, 2))
    precision = _precisions(4.0, 3)
    for strength, found in enumerate(flight.log_likelihoods(shift, spread)):
        density = [
            np.exp(log_weight[scale])
            * multivariate_normal(
                predicted.error[0, scale],
                known[scale]
                + scatter[scale] / own[0]
                + np.diag(reading[scale] / own[1:])
                + np.outer(spread[strength], spread[strength]),
            ).pdf(shift[strength])
            for scale in range(3)
            for own in precision
        ]
        assert found == pytest.approx(np.log(sum(density) / len(precision)), abs=1e-9)
