"""BDureau's boards: sentences with a checksum."""

import numpy as np

from tools.samples.one_parachute import flight


def sentence(body: str) -> str:
    return f"${body}{sum(body.encode()) % 256};\n"


def bdureau() -> dict[str, bytes]:
    made = flight(thrust=45.0, burn=1.4, descent=9.0)
    time = np.arange(0.0, made.time[-1], 0.1)
    height = np.round(made.at(time, made.height))
    pascal = np.round(made.pressure(height))
    config = "alticonfig,1,0,1,2,3,0,100,AltiMultiSTM32,2,1,0,0,0,440,5,5,0,0,38400,1,"
    long = "$start;\n" + sentence(config) + "$end;\n$start;\n"
    for i, t in enumerate(time):
        body = f"data,0,{t * 1000:.0f},{height[i]:.0f},21,{pascal[i]:.0f},742,"
        long += sentence(body).replace(";", "9;") if i == 40 else sentence(body)
        if i == 100:
            long += sentence(f"telemetry,{height[i]:.0f},1,1,230,0,-1,0,{t * 1000:.0f},1,1,-1,-1,7.42,21,5,2,100,")
    for i, t in enumerate(time[::2]):
        long += sentence(
            f"data,1,{t * 1000:.0f},{height[::2][i] // 2:.0f},20,{made.pressure(height[::2] // 2)[i]:.0f},731,"
        )
    eight = "$start;\n"
    times = np.arange(0.0, 80.0, 0.4)
    descent = np.interp(times, [0, 2, 6, 75, 80], [0, 100, 240, 0, 0])
    for t, h in zip(times, descent, strict=True):
        wrapped = int(made.pressure(np.array(h))) % 65536
        eight += sentence(f"data,0,{int(t * 1000) % 65536},{h:.0f},19,{wrapped},")
    return {
        "bdureau__two_flights_and_telemetry_between.txt": (long + "$end;\n").encode(),
        "bdureau__eight_bit_board_that_wraps.txt": (eight + "$end;\n").encode(),
    }


MAKERS = (bdureau,)
