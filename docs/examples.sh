# A session that has every command in it. The tests run it line by line, in the folder of the checkout, on an empty ledger.

# what a file is and what would be stored of it: nothing is
fieldkit inspect sample_logs/perfectflite__drogue_and_main.pf2
# a table of flights; what is there already changes nothing
fieldkit import fieldkit/data/reference_flights.csv
# say first what would happen
fieldkit import --dry-run fieldkit/data/reference_flights.csv
# a logger's file, and what it does not hold
fieldkit import sample_logs/perfectflite__drogue_and_main.pf2 --set rocket=Comet --set motor=F24-4W --set dry_mass=300g --set diameter=66mm
# the columns of other tables, as they were named once
fieldkit mappings
# everything in one line, each figure in the unit it was read in
fieldkit add --rocket Astra --config A --motor F24-4W --dry-mass 322g --diameter 66mm --apogee 935ft --wind 5mph

fieldkit flights
fieldkit flights --rocket Comet
fieldkit show 1
# as JSON, for scripts
fieldkit show 1 --json
fieldkit edit 2 apogee=281m
# an empty value clears
fieldkit edit 2 notes=
# an anomaly: the flight stays, and does not teach
fieldkit tag 13 off_axis
fieldkit untag 13 off_axis
fieldkit remove 13
# and back again
fieldkit undo
fieldkit redo
fieldkit undo
fieldkit history
fieldkit export flights.csv
fieldkit export flights.json --rocket Comet

fieldkit infer 1 2 3
# what the reference paper's own network says
fieldkit infer 1 --model paper
fieldkit predict --rocket Astra --config A --motor F24-4W
# other conditions
fieldkit predict --rocket Astra --config A --motor F24-4W --dry-mass 330g --wind 8mph --temperature 95F --site-elevation 4500ft
fieldkit motors F24
# all there is in a diameter
fieldkit motors aerotech 24mm
# every motor that fits a rocket, nearest to a target first
fieldkit motors --fit Comet --target 800ft --class F
fieldkit motors --about
fieldkit delay --rocket Astra --motor F24
fieldkit ballast --rocket Astra --motor F24-4W --target 800ft
fieldkit contest --rocket Astra --season 2026
# the score of the flights that were declared, and a plan for the next season
fieldkit contest --rocket Astra --season 2026 --declared 2,3,9
# mass and parachute for every target that finals may have, in the day's air, on one card
fieldkit finals --rocket Astra --season 2027 --motor F39T-6 --temperature 25c --wind 3m/s --card finals.png
# where a plan lands, and which rail angle brings it back
fieldkit landing --rocket Astra --motor F24-4W --wind 4m/s --wind-aloft 9m/s --field-size 400m
# one flight from what you say, none of it from your own flights
fieldkit simulate --motor F24-4W --dry-mass 322g --diameter 66mm --cd 0.6 --alpha 1 --wind 5mps

# look only: nothing is kept
fieldkit loop --rocket Astra --look
# at a glance of the network
fieldkit loop --rocket Astra --quick
fieldkit model --rocket Astra
# the plain model, whatever the loop added
fieldkit model --rocket Astra --use 0
fieldkit score --rocket Astra
# two recordings of one flight, the first being the measure
fieldkit compare flight-dd2afbb08f sample_logs/perfectflite__drogue_and_main.pf2
# the logs of flights, measured again
fieldkit remeasure --dry-run
# a field you fly from: plans take its elevation and its limits over
fieldkit sites "North field" --elevation 212m --size 400m --ceiling 900m
fieldkit predictions
fieldkit report 2 --out card.pdf
fieldkit backups
# the ports there are, and the loggers that can be read
fieldkit capture --list
fieldkit docs
fieldkit docs predictions
