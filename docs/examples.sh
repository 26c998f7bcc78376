# A session with every other command. The tests run it line by line in the checkout, with an empty ledger.

# show what a file contains, without storing anything
fieldkit inspect sample_logs/perfectflite__drogue_and_main.pf2
# the twelve flights of the manual's examples; duplicates change nothing
fieldkit import --example
# show first what would happen
fieldkit import --dry-run fieldkit/data/reference_flights.csv
# a logger's file, and the values that it lacks
fieldkit import sample_logs/perfectflite__drogue_and_main.pf2 --set rocket=Comet --set motor=F24-4W --set dry_mass=300g --set diameter=66mm
# a logger with satellite positions, and its track for a map
fieldkit import sample_logs/altos_csv__with_satellites.csv
fieldkit track flight-4f3b53f6c1 --out track.kml
# the saved column mappings
fieldkit mappings
# a flight in one line, each figure with the unit of the altimeter
fieldkit add --rocket Astra --config A --motor F24-4W --dry-mass 322g --diameter 66mm --apogee 935ft --wind 5mph

fieldkit flights
fieldkit flights --rocket Comet
fieldkit show 1
# as JSON, for scripts
fieldkit show 1 --json
fieldkit edit 2 apogee=281m
# an empty value clears
fieldkit edit 2 notes=
# an anomaly: the flight stays, but is not used in the model
fieldkit tag 13 off_axis
fieldkit untag 13 off_axis
fieldkit remove 13
# undo and redo
fieldkit undo
fieldkit redo
fieldkit undo
fieldkit history
fieldkit export flights.csv
fieldkit export flights.json --rocket Comet

fieldkit infer 1 2 3
# with the reference paper's own network
fieldkit infer 1 --model paper
fieldkit predict --rocket Astra --config A --motor F24-4W
# other conditions
fieldkit predict --rocket Astra --config A --motor F24-4W --dry-mass 330g --wind 8mph --temperature 95F --site-elevation 4500ft
fieldkit motors F24
# all motors of a maker and a diameter
fieldkit motors aerotech 24mm
# every motor that fits a rocket, nearest to a target first
fieldkit motors --fit Comet --target 800ft --class F
fieldkit motors --about
fieldkit delay --rocket Astra --motor F24
fieldkit ballast --rocket Astra --motor F24-4W --target 800ft
fieldkit contest --rocket Astra --season 2026
# the score of the declared flights
fieldkit contest --rocket Astra --season 2026 --declared 2,3,9
# a season step by step: limits, mass and parachute, practice, qualification, finals
fieldkit season --rocket Astra --season 2027 --motor F39T-6
# mass and parachute for every target that the finals may announce, with the day's weather, on one card
fieldkit finals --rocket Astra --season 2027 --motor F39T-6 --temperature 25c --wind 3m/s --card finals.png
# where a plan lands, and which rail angle lands it nearest the pad
fieldkit landing --rocket Astra --motor F24-4W --wind 4m/s --wind-aloft 9m/s --field-size 400m
fieldkit daysheet --rocket Astra --motor F24-4W --wind 4m/s --field-size 400m --out sheet.pdf
# one simulated flight from these values only
fieldkit simulate --motor F24-4W --dry-mass 322g --diameter 66mm --cd 0.6 --alpha 1 --wind 5mps

# show only: the model does not change
fieldkit loop --rocket Astra --dry-run
# the same at once, provisional
fieldkit loop --rocket Astra --quick
fieldkit model --rocket Astra
# go back to forecasts without a correction
fieldkit model --rocket Astra --use 0
fieldkit score --rocket Astra
# two recordings of one flight; the first is the reference
fieldkit compare flight-dd2afbb08f sample_logs/perfectflite__drogue_and_main.pf2
# measure the logs of flights again
fieldkit remeasure --dry-run
# the units of every command and of the app, and back to SI
fieldkit units US
fieldkit units SI
# a field you fly from: plans use its elevation and its limits
fieldkit sites "North field" --elevation 212m --size 400m --ceiling 900m
fieldkit kits "Big Bertha" --dry-mass 80g --diameter 41.6mm --mount 18mm
fieldkit flyer --certification 1 --born 2009-05-31 --rails 3ft,1.8m
fieldkit predictions
fieldkit report 2 --out card.pdf
fieldkit backups
# the serial ports, and the loggers that can be read
fieldkit capture --list
fieldkit docs
fieldkit docs predictions
fieldkit simulate --motor D12-0/C6-0/C6-7 --booster-mass 60g/40g --dry-mass 100g --diameter 30mm --cd 0.6

# the weather of a flight from a saved file, hours or years later
fieldkit add --rocket Astra --config A --motor F24-4W --dry-mass 322g --diameter 66mm --apogee 268m --date-time 2026-05-16T14:30 --site Moor --site-elevation 440m
fieldkit weather docs/example-weather.csv --site Moor --dry-run
fieldkit weather docs/example-weather.csv --site Moor
