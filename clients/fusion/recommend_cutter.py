#!/usr/bin/env python3
"""Ranks the finishing cutters of Fusion tool libraries for a surface.

Export the library in Fusion's tool library dialog (Export, as .json or .tools) and the surface as STL, OBJ or 3MF, then:

    recommend_cutter.py part.stl library.tools
"""

import argparse
import sys

import scallopd
from scallopd import ranking


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("surface", help="STL, OBJ, PLY, 3MF or text")
    parser.add_argument("library", nargs="+", help="tool library exported by Fusion, .json or .tools")
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--scallop-tolerance-mm", "--scallop-height-mm", type=float, default=0.01)
    parser.add_argument("--machine", default="vmc", help="a preset of the server (default: %(default)s)")
    parser.add_argument("--unit", choices=["mm", "inch"], default="mm", help="unit of the surface file; libraries state their own")
    parser.add_argument("--rows", type=int, default=20, help="rows of the table (default: %(default)s)")
    options = parser.parse_args()
    with scallopd.Client(options.server) as client:
        try:
            recommendation = client.recommend_file(
                options.surface, [], options.scallop_tolerance_mm, options.machine, libraries=options.library, unit=options.unit
            )
        except scallopd.NoCutterFits as problem:
            print(problem.detail, file=sys.stderr)
            print("\n".join(f"  {row[0]}: {row[1]}" for row in map(ranking.not_ranked, problem.not_ranked)), file=sys.stderr)
            return 1
        except (scallopd.ScallopdError, OSError) as error:
            print(error, file=sys.stderr)
            return 1
    print(ranking.text(recommendation, options.rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
