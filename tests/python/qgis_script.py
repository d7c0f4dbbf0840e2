"""The script for QGIS, in QGIS' own Python without a display: runs a small scene, and its maps are layers with styles. Called by test_qgis.py."""
import importlib.util
import os
import pathlib
import sys

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
from qgis.core import QgsApplication, QgsProcessingContext, QgsProcessingFeedback, QgsProject, QgsRasterLayer  # noqa: E402

scene, output = map(pathlib.Path, sys.argv[1:])
application = QgsApplication([], False)
application.initQgis()
spec = importlib.util.spec_from_file_location("moraine_run", pathlib.Path(__file__).resolve().parents[2] / "python/qgis/moraine_run.py")
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
algorithm = module.MoraineRun().create()
project, context = QgsProject(), QgsProcessingContext()
context.setProject(project)
dem = QgsRasterLayer(str(scene.parent / "dem.asc"), "dem")
assert dem.isValid()
project.addMapLayer(dem)
found, good = algorithm.run({"SCENE": str(scene), "DEM": dem.id(), "CELL": 2.0, "SETS": "time.end=0.2\nhazard.threshold=0.1", "OUTPUT": str(output)}, context,
                            QgsProcessingFeedback())
assert good, "the algorithm failed"
store = context.temporaryLayerStore()
for identity in found["MAPS"]:
    layer = store.mapLayer(identity)
    kind = layer.renderer().type() if hasattr(layer, "bandCount") else "vector"
    print(layer.name(), kind, len(layer.renderer().shader().rasterShaderFunction().colorRampItemList()) if kind == "singlebandpseudocolor" else layer.featureCount())
