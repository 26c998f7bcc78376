"""AltiMulti and similar: sentences with a checksum, several flights in one text, boards that print numbers modulo 16
bits."""

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note, Parsed, Reading
from fieldkit.importing.recognize import parsers


def sentence(body: str) -> bytes:
    return f"${body}{sum(body.encode()) % 256};\n".encode()


def data(*samples: str) -> bytes:
    return b"$start;\n" + b"".join(sentence(f"data,{sample},") for sample in samples) + b"$end;\n"


def read(log: bytes) -> list[Parsed]:
    return list(parsers()["bdureau"].read(log))


def flights(log: bytes) -> list[Reading]:
    return [item for item in read(log) if isinstance(item, Reading)]


@pytest.mark.parametrize(
    "published",
    [b"$testTrame,Bear altimeters are the best!!!!,240;", b"$data,0,50,12,21,100873,48;", b"$nbrOfFlight,3,224;"],
)
def test_the_checksum_is_the_published_one(published: bytes) -> None:
    body, _, check = published[1:-1].rpartition(b",")
    assert sentence(body.decode() + ",") == b"$" + body + b"," + check + b";\n"


def test_a_published_sample_is_converted_to_si() -> None:
    (flight,) = flights(b"$start;\n$data,0,50,12,21,100873,48;\n$end;\n")
    (series,) = flight.clocks
    assert (series.time, series.altitude, series.pressure) == ([0.05], [12], [100873])
    assert series.temperature == pytest.approx([294.15])


def test_a_wrong_checksum_loses_only_its_sample() -> None:
    log = data("0,50,12,21,100873", "0,100,15,21,100840", "0,150,19,21,100800").replace(b",15,", b",95,")
    flight, damaged = read(log)
    assert isinstance(flight, Reading)
    assert flight.clocks[0].time.tolist() == [0.05, 0.15]
    assert isinstance(damaged, DamagedLog)
    assert damaged.row == 3


def test_flights_in_one_text_stay_separate() -> None:
    one, other = flights(data("0,50,12,21,100873", "3,50,1,20,100900", "0,100,15,21,100840"))
    assert (one.extra["flight_number"], other.extra["flight_number"]) == ("0", "3")
    assert len(one.clocks[0].time) == 2


def test_time_and_pressure_of_an_eight_bit_board_are_unwrapped() -> None:
    times = np.arange(0, 150_000, 5_000)
    log = data(*(f"0,{t % 65536},{h},20,{100_873 % 65536 - 12 * h}" for t, h in zip(times, range(30), strict=True)))
    (flight,) = flights(log)
    (series,) = flight.clocks
    assert series.time.tolist() == (times / 1000).tolist()
    assert series.pressure is not None
    assert series.pressure.tolist() == [100_873 - 12 * h for h in range(30)]


def test_the_columns_after_the_pressure_depend_on_the_board() -> None:
    sample = "0,50,12,21,100873,742,4710000,840000,320,9,12,318"
    flight, note = read(data(sample, sample))
    assert isinstance(flight, Reading)
    assert flight.clocks[0].latitude is None
    assert isinstance(note, Note)
    config = sentence("alticonfig,0,0,1,2,3,0,100,AltiGPS,1,4,0,0,0,440,5,5,0,0,38400,1,")
    (flight,) = flights(config + data(sample, sample))
    (series,) = flight.clocks
    assert series.latitude == pytest.approx([47.1, 47.1])
    assert series.gps_altitude_msl == pytest.approx([320, 320])
    assert (flight.device, flight.firmware) == ("bdureau AltiGPS", "1.4")


def test_a_capture_of_only_telemetry_states_its_apogee() -> None:
    rows = [("0,0,0,0", 0), ("40,1,0,0", 1000), ("118,1,1,121", 5000), ("0,1,1,121", 30_000)]
    log = b"".join(
        sentence(f"telemetry,{row},{int(t > 9000)},50,{int(t > 9000)},{t},1,1,-1,-1,7.4,") for row, t in rows
    )
    (flight,) = flights(log)
    assert flight.stated == {"apogee": 121}
    assert flight.events == {"liftoff": 1, "apogee": 5, "main": 30, "landing": 30}


def test_a_capture_without_a_sample_is_not_a_flight() -> None:
    with pytest.raises(DamagedLog, match="no sample of a flight"):
        read(b"$start;\n" + sentence("nbrOfFlight,3,") + b"$end;\n")


def test_more_flights_than_an_altimeter_holds_are_refused_at_once() -> None:
    log = data(*(f"{flight},50,12,21,100873" for flight in range(5000)))
    with pytest.raises(DamagedLog, match="more than 100 flights"):
        read(log)
