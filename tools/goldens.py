"""Write the values read from the sample logs, for `tests/parsers/test_every_parser.py`; review the changes.

python -m tools.goldens [PART OF A NAME]

"""

import json
import sys

from fieldkit.importing.read import read
from tests.parsers.test_every_parser import GOLDEN, summary
from tests.samples import SAMPLES, any_motor


def main(part: str) -> None:
    for sample in SAMPLES:
        if part in sample.name:
            figures = summary(read(sample.read_bytes(), sample.name, any_motor))
            golden = GOLDEN / f"{sample.name}.json"
            golden.write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            print(golden.name)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "")
