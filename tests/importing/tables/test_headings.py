"""Headers of tables of samples: words in several languages, units beside a name, and names that are no samples."""

import pytest

from fieldkit.importing.tables.headings import channel, heading, stated_unit, unit_named

pytestmark = pytest.mark.fast

TRANSLATED = {
    "German": "Zeit (s);Höhe über Grund (m);Geschwindigkeit (m/s);Beschleunigung (g);Luftdruck (hPa)",
    "German, compounds": "Laufzeit [s];Flughöhe [m];Steiggeschwindigkeit [m/s];Beschl. [g];Druck [mbar]",
    "German, in words": "Zeit in s;Höhe in m;Geschwindigkeit in m/s;Beschleunigung in g;Luftdruck in hPa",
    "French": "Temps (s);Hauteur au-dessus du sol (m);Vitesse (m/s);Accélération (g);Pression (hPa)",
    "French, as in science": "temps/s;altitude/m;vitesse/(m/s);accélération/g;pression/hPa",
    "Spanish": "Tiempo (s);Altura sobre el suelo (m);Velocidad (m/s);Aceleración (g);Presión (hPa)",
    "Spanish without accents": "tiempo_s;altitud_m;velocidad_mps;aceleracion_g;presion_hpa",
    "Italian": "Tempo (s);Quota (m);Velocità (m/s);Accelerazione (g);Pressione (hPa)",
    "Portuguese": "Tempo (s);Altura (m);Velocidade (m/s);Aceleração (g);Pressão (hPa)",
    "Dutch": "Tijd (s);Hoogte (m);Snelheid (m/s);Versnelling (g);Luchtdruk (hPa)",
    "Swedish": "Tid (s);Höjd (m);Hastighet (m/s);Acceleration (g);Lufttryck (hPa)",
    "Polish": "Czas (s);Wysokość (m);Prędkość (m/s);Przyspieszenie (g);Ciśnienie (hPa)",
    "Czech": "Čas (s);Výška (m);Rychlost (m/s);Zrychlení (g);Tlak (hPa)",
    "Russian": "Время (с);Высота (м);Скорость (м/с);Ускорение (g);Давление (hPa)",
    "Chinese": "时间 (s);高度 (m);速度 (m/s);加速度 (g);气压 (hPa)",
    "Japanese": "時間 (s);高度 (m);速度 (m/s);加速度 (g);気圧 (hPa)",
}


@pytest.mark.parametrize("names", TRANSLATED.values(), ids=TRANSLATED)
def test_names_in_other_languages_have_their_channels_and_units(names: str) -> None:
    heads = [heading(name) for name in names.split(";")]
    assert [channel(head) for head in heads] == ["time", "altitude", "speed", "felt?", "pressure"]
    assert all(stated_unit(head, channel(head).replace("felt?", "felt")) for head in heads)


@pytest.mark.parametrize(
    ("spelled", "name", "unit"),
    [
        ("time_min", "time", "min"),
        ("seconds_since_boot", "time", ""),
        ("Sekunden", "time", "sekunden"),
        ("Meters", "altitude", "meters"),
        ("t/s", "time", "s"),
        ("h/m", "altitude", "m"),
        ("v/(m/s)", "speed", "m/s"),
        ("z_m", "altitude", "m"),
        ("elevation_m", "altitude", "m"),
        ("v (m/s)", "speed", "m/s"),
        ("V (V)", "voltage", "V"),
        ("T (°C)", "temperature", "°C"),
        ("climb rate (ft/s)", "speed", "ft/s"),
        ("up_fps", "speed", "fps"),
        ("baro_m", "altitude", "m"),
        ("pressure_m", "pressure", ""),
        ("baro_time_ms", "time", "ms"),
        ("Baro (in)", "pressure", "in"),
        ("Altitude (AGL ft)", "altitude", "ft"),
        ("Altitude (ft, AGL)", "altitude", "ft"),
        ("Altitude m (BMP280)", "altitude", "m"),
        ("Abs Pres, psi (S/N 12)", "pressure", "psi"),
        ("Altitude (furlong)", "altitude", "furlong"),
        ("Altura a nivel del mar (m)", "altitude_msl", "m"),
        ("Höhe über NN [m]", "altitude_msl", "m"),
        ("Altitude sol (m)", "altitude", "m"),
        ("ALTITUDE_FT_MSL", "altitude_msl", "ft"),
        ("accel_g_x", "felt_x", "g"),
        ("vel_fps_up", "speed", "fps"),
        ("time (h)", "time", "h"),
    ],
)
def test_a_name_may_be_a_letter_or_a_word_beside_its_unit(spelled: str, name: str, unit: str) -> None:
    head = heading(spelled)
    assert (channel(head), stated_unit(head, name)) == (name, unit)


@pytest.mark.parametrize(
    "spelled",
    [
        "z",
        "v",
        "p",
        "ms",
        "min time (s)",
        "Altitude (min)",
        "Altitude (predicted) (m)",
        "Altitude rate (m/s)",
        "elevation (deg)",
        "Pressure (mm)",
        "Altitude du sol (m)",
        "Vitesse sol (km/h)",
        "Velocidad del viento (m/s)",
        "Drehrate (°/s)",
        "Pression au niveau de la mer (hPa)",
        "chamber_psi",
        "speed of sound (m/s)",
    ],
)
def test_a_name_without_one_certain_meaning_is_no_channel(spelled: str) -> None:
    assert channel(heading(spelled)) == ""


@pytest.mark.parametrize("spelled", ["GForce", "G's", "G-Force (G)", "g force", "gforce_g"])
def test_g_forces_are_accelerations(spelled: str) -> None:
    assert channel(heading(spelled)) == "felt?"
    assert channel(heading(f"{spelled} max")) != "altitude"


def test_the_range_of_an_accelerometer_is_not_its_unit() -> None:
    head = heading("Accel Z (16g)")
    assert unit_named("acceleration", stated_unit(head, "felt_z")) == unit_named("acceleration", "g")
