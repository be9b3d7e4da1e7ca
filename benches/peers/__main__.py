"""Compares transect with other ways to fill the space between sections.

./x bench peers runs it; README.md says what is measured."""

import argparse
import json
import os
import sys

# Threads of linear algebra that wait for each other on a busy machine can take
# ten times as long as a single one. This must come before numpy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import labels.compare  # noqa: E402
import methods  # noqa: E402
import shapes  # noqa: E402
import table  # noqa: E402
from cuts import KINDS  # noqa: E402


def arguments():
    every = [*methods.OURS, *methods.PEERS]
    parser = argparse.ArgumentParser(prog="./x bench peers", description=__doc__.split("\n")[0])
    words = {"type": lambda text: text.split(","), "metavar": "NAME,..."}
    parser.add_argument("what", nargs="?", choices=["shapes", "labels", "both"], default="both",
                        help="what to compare [default: both]")
    parser.add_argument("--only", **words, help="inputs whose names contain one of these")
    parser.add_argument("--methods", **words, default=every, help=f"of {', '.join(every)}")
    parser.add_argument("--cuts", **words, default=list(KINDS), help=f"of {', '.join(KINDS)}")
    parser.add_argument("--resolution", type=int, default=256, metavar="N",
                        help="voxels on the longest side, for reconstructing [default: 256]")
    parser.add_argument("--solids", metavar="DIR", help="a folder of closed meshes, .ply")
    parser.add_argument("--json", metavar="FILE", help="write all figures here, too")
    return parser.parse_args()


def main():
    options = arguments()
    names, missing = methods.available(options.methods)
    for name, why in missing.items():
        print(f"left out: {name}: {why}")
    results = {}
    if options.what != "labels":
        results["shapes"] = shapes.compare(names, options)
        for kind, title in KINDS.items():
            rows = [row for row in results["shapes"] if row["cut"] == kind]
            table.show(title, rows, table.SHAPES)
    if options.what != "shapes":
        results["labels"] = labels.compare.compare(names, options)
        table.show("volumes of labels, every sixth slice", results["labels"], table.LABELS)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
    # ITK's libraries damage the heap while they are unloaded (seen with 5.4),
    # when all is done and written: leave without unloading.
    sys.stdout.flush()
    os._exit(0)
