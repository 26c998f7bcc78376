# Commands that stay open, compute for long, or read a file of yours: the tests check their options here, and `-m slow`
# runs those that end.

fieldkit tui
# in a browser on this computer
fieldkit serve --port 8010
# for a phone on the same network: prints a link with a token
fieldkit serve --host 0.0.0.0
fieldkit demo
# a rocket that has not flown, from its design
fieldkit ork skylark.ork
# the reference flights, compared with what was published
fieldkit paper
fieldkit study reference --out reference-study.md
fieldkit study rockets --out rockets.md
# how much rockets, motors, and flights vary, from the exports of a club's flyers; cross-validated by rocket
fieldkit learn anna.csv ben.csv --check --out club.json
fieldkit learn anna.csv ben.csv --keep
# the reference paper's ensemble again: needs the extra `train`
fieldkit train --recipe paper --schedule published --seed 1 --n-train 10000 --out paper-again
