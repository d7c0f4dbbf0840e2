// In place of GDAL where the build has none.
#include "core/data/error.hpp"
#include "io/gis_file.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

[[noreturn]] void refuse_format(const std::string& path, const std::string& key, const std::string& known) {
    refuse(path, "the file of " + key + " cannot be read", "this build has no GDAL and reads " + known,
           "Convert it, or build with libgdal-dev?");
}

}  // namespace

bool has_gdal() {
    return false;
}

Ground read_gis_raster(const std::string& path, const RasterUse& use, const std::function<NodeWindow(const Ground&)>&,
                       std::vector<std::string>&) {
    refuse_format(path, use.key, "ESRI ASCII grids, .asc: gdal_translate -of AAIGrid");
}

bool are_same_crs(const std::string&, const std::string&, const std::array<double, 2>&, const std::array<double, 2>&,
                  double) {
    return true;
}

void check_scale(const Ground&, const std::string&) {}

std::string crs_beside(const std::string&) {
    return {};
}

std::vector<GisShape> read_gis_shapes(const std::string& path, const std::string& key, GisKind, const std::string&,
                                      std::vector<std::string>&) {
    refuse_format(path, key, ".csv and .geojson");
}

std::string geotiff_bytes(const MapImage&) {
    throw MachineError("this build has no GDAL");
}

std::string outline_bytes(const std::vector<Rings>&, const std::string&, double, const MapTags&) {
    throw MachineError("this build has no GDAL");
}

}  // namespace moraine
