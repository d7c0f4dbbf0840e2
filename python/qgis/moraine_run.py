"""A script for QGIS' Processing toolbox: runs a scene over terrain with the release areas of a layer, and loads its maps with their styles.

Processing toolbox > Scripts > Add Script to Toolbox, and choose this file. It starts the program, which the environment's MORAINE_PROGRAM or the path
names; QGIS' own Python is enough.
"""
import os
import pathlib
import shutil
import subprocess

from qgis.core import (QgsProcessing, QgsProcessingAlgorithm, QgsProcessingException, QgsProcessingParameterFile, QgsProcessingParameterFolderDestination,
                       QgsProcessingParameterNumber, QgsProcessingParameterRasterLayer, QgsProcessingParameterString, QgsProcessingParameterVectorLayer,
                       QgsRasterLayer, QgsVectorFileWriter, QgsVectorLayer)


def program():
    """Where the program is."""
    found = shutil.which(os.environ.get("MORAINE_PROGRAM", "moraine"))
    if not found:
        raise QgsProcessingException("The program moraine was not found (neither MORAINE_PROGRAM nor the path names it). Set MORAINE_PROGRAM to where it is?")
    return found


class MoraineRun(QgsProcessingAlgorithm):
    """Scene, model of heights and areas in; a folder of maps out."""

    def name(self):
        return "moraine_run"

    def displayName(self):
        return "Run a scene over terrain"

    def group(self):
        return "Moraine"

    def groupId(self):
        return "moraine"

    def shortHelpString(self):
        return ("Runs a scene of Moraine: its [terrain] and its first [[release]] are taken from the layers that are chosen, all else from the file. "
                "The maps are loaded with the styles that lie beside them.")

    def createInstance(self):
        return MoraineRun()

    def initAlgorithm(self, configuration=None):
        self.addParameter(QgsProcessingParameterFile("SCENE", "Scene", extension="toml"))
        self.addParameter(QgsProcessingParameterRasterLayer("DEM", "Model of heights", optional=True))
        self.addParameter(QgsProcessingParameterVectorLayer("AREA", "Areas of the release", [QgsProcessing.TypeVectorPolygon], optional=True))
        self.addParameter(QgsProcessingParameterString("RELEASE", "Name of the release that they replace", optional=True))
        self.addParameter(QgsProcessingParameterNumber("CELL", "Cell [m], 0: that of the scene", QgsProcessingParameterNumber.Double, 0.0, minValue=0.0))
        self.addParameter(QgsProcessingParameterString("SETS", "Other keys, as terrain.contact.friction=0.2", optional=True, multiLine=True))
        self.addParameter(QgsProcessingParameterFolderDestination("OUTPUT", "Folder of the run"))

    def words(self, parameters, context):
        """Options of the program, without the scene."""
        found = []
        dem, area = self.parameterAsRasterLayer(parameters, "DEM", context), self.parameterAsVectorLayer(parameters, "AREA", context)
        folder = pathlib.Path(self.parameterAsString(parameters, "OUTPUT", context))
        if dem:
            found += ["--set", f'terrain.dem="{pathlib.Path(dem.source()).resolve()}"']
        if area:
            release = self.parameterAsString(parameters, "RELEASE", context)
            if not release:
                raise QgsProcessingException("Which release do the areas replace (it has no name)? Give that of the scene's [[release]].")
            written = folder.parent / f"{folder.name}-area.gpkg"
            options = QgsVectorFileWriter.SaveVectorOptions()
            options.driverName = "GPKG"
            problem = QgsVectorFileWriter.writeAsVectorFormatV3(area, str(written), context.transformContext(), options)
            if problem[0] != QgsVectorFileWriter.NoError:
                raise QgsProcessingException(f"The areas cannot be written ({problem[1]}).")
            found += ["--set", f'release.{release}.area="{written.resolve()}"']
        cell = self.parameterAsDouble(parameters, "CELL", context)
        if cell > 0:
            found += ["--set", f"domain.cell={cell!r}"]
        for line in (self.parameterAsString(parameters, "SETS", context) or "").splitlines():
            if line.strip():
                found += ["--set", line.strip()]
        return found, folder

    def processAlgorithm(self, parameters, context, feedback):
        words, folder = self.words(parameters, context)
        scene = self.parameterAsString(parameters, "SCENE", context)
        folder.parent.mkdir(parents=True, exist_ok=True)
        job = subprocess.Popen([program(), "run", scene, "--output", str(folder), "--overwrite", "--no-particles", *words], stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
        said = []
        for line in job.stderr:
            said.append(line.rstrip())
            feedback.pushInfo(said[-1])
            if feedback.isCanceled():
                job.terminate()
        if job.wait() != 0:
            raise QgsProcessingException(next((line for line in said if line.startswith("moraine: ")), f"moraine ended with exit code {job.returncode}"))
        return {"OUTPUT": str(folder), "MAPS": [layer.id() for layer in self.load(folder, context)]}

    def load(self, folder, context):
        """Maps and outline as layers of the project."""
        layers = []
        files = sorted((folder / "maps").iterdir())
        for path in [path for path in files if path.suffix in (".tif", ".asc", ".gpkg", ".geojson")]:
            layer = QgsRasterLayer(str(path), path.stem) if path.suffix in (".tif", ".asc") else QgsVectorLayer(str(path), path.stem, "ogr")
            if not layer.isValid():
                raise QgsProcessingException(f"{path} cannot be loaded.")
            if path.with_suffix(".qml").is_file():
                layer.loadNamedStyle(str(path.with_suffix(".qml")))
            context.temporaryLayerStore().addMapLayer(layer)
            context.addLayerToLoadOnCompletion(layer.id(), context.LayerDetails(layer.name(), context.project(), layer.name()))
            layers.append(layer)
        return layers
