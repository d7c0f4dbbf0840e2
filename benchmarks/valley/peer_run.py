"""Runs the peer's depth-averaged model on one case, in the peer's own environment (beside_avaframe makes it).

    python peer_run.py CASE_DIRECTORY       with dem.asc, release.json and case.json in it

Writes peer.json with the wall time; the peer's rasters stay in CASE_DIRECTORY/peer/Outputs.
"""
import json
import pathlib
import shutil
import sys
import time

import shapefile
from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils, initializeProject, logUtils

NUMBERS = {"meshCellSize": "dem_cell", "rho": "density", "muvoellmy": "friction", "xsivoellmy": "xi", "tEnd": "end"}


def main():
    case = pathlib.Path(sys.argv[1]).resolve()
    said = json.loads((case / "case.json").read_text())
    ava = case / "peer"
    initializeProject.initializeFolderStruct(str(ava), removeExisting=True)
    shutil.copy(case / "dem.asc", ava / "Inputs" / "dem.asc")
    with shapefile.Writer(str(ava / "Inputs" / "REL" / "release"), shapefile.POLYGON) as file:
        file.field("name", "C")
        file.field("thickness", "N", decimal=3)
        corners = json.loads((case / "release.json").read_text())
        file.poly([corners + corners[:1]])
        file.record("release", said["thickness"])
    main_config = cfgUtils.getGeneralConfig()
    main_config["MAIN"]["avalancheDir"] = str(ava)
    main_config["MAIN"]["nCPU"] = "1"
    for flag in ("showPlot", "savePlot", "createReport", "ReportDir"):
        main_config["FLAGS"][flag] = "False"
    logUtils.initiateLogger(str(ava), "run")
    config = cfgUtils.getModuleConfig(com1DFA, str(ava), toPrint=False)
    general = config["GENERAL"]
    general["frictModel"], general["simTypeList"], general["relThFromFile"] = "Voellmy", "null", "True"
    for key, name in NUMBERS.items():
        general[key] = str(said[name])
    start = time.monotonic()
    com1DFA.com1DFAMain(main_config, cfgInfo=config)
    (case / "peer.json").write_text(json.dumps({"seconds": round(time.monotonic() - start, 1)}))


if __name__ == "__main__":
    main()
