# What stays open, or computes for longer than a look-up takes: the tests check how it is written, and run the commands elsewhere.

fieldkit tui
# in a browser on this computer
fieldkit serve --port 8010
# for a phone in the same network: prints a link with a token
fieldkit serve --host 0.0.0.0
fieldkit demo
# a rocket that has not flown, from its design
fieldkit ork skylark.ork
# the reference flights, next to what was published of them
fieldkit paper
fieldkit study reference --out reference-study.md
fieldkit study rockets --out rockets.md
# how far rockets, motors and flights differ, from the exports of a club's flyers; each rocket forecast without it
fieldkit learn anna.csv ben.csv --check --out club.json
fieldkit learn anna.csv ben.csv --keep
# the shipped field ensemble, anew, with its verdict
fieldkit train --report --recipe field --schedule published --seed 1 --n-train 1000000 --out DIR
# the track of a logger with satellite positions, for a map
fieldkit track flight-dd2afbb08f --out track.kml
# the network of whole histories that answers loop --quick; cut short, it goes on where it was
fieldkit train --recipe history --schedule published --seed 1 --n-train 14000 --out DIR
# the reference paper's ensemble, anew: needs the extra named train
fieldkit train --recipe paper --schedule published --seed 1 --n-train 10000 --out paper-again
# one that also reckons with wind and a wrong mass
fieldkit train --recipe field --effects wind,mass_offset --out field-wind
