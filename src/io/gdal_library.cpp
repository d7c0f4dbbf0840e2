#include "io/gdal_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "core/data/error.hpp"
#include "io/gis_file.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

void* found(void* library, const char* name) {
    void* function = dlsym(library, name);
    if (!function)
        throw MachineError(fmt::format("GDAL cannot be used ({} has no {}). Is it the version that this build found?",
                                       MORAINE_GDAL_LIBRARY, name));
    return function;
}

/// All that stay.
constexpr std::string_view drivers[] = {"GTiff", "AAIGrid", "netCDF", "GPKG", "ESRI Shapefile", "GeoJSON", "VRT"};

GdalLibrary load() {
    void* library = dlopen(MORAINE_GDAL_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        throw MachineError(
            fmt::format("GDAL cannot be loaded ({}). Install it, or use .asc, .csv and .geojson?", dlerror()));
    GdalLibrary g;
#define MORAINE_GDAL_FIND(name) g.name = reinterpret_cast<decltype(g.name)>(found(library, #name));
    MORAINE_GDAL_FUNCTIONS(MORAINE_GDAL_FIND)
#undef MORAINE_GDAL_FIND
    g.CPLPushErrorHandler(g.CPLQuietErrorHandler);
    g.CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");  // no files beside those that are read
    g.CPLSetConfigOption("GDAL_CACHEMAX", "64");     // [MB], not 5 % of the machine's memory
    g.CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_FILENAME", "none");
    g.OSRSetPROJEnableNetwork(FALSE);
    g.GDALAllRegister();
    for (int k = g.GDALGetDriverCount() - 1; k >= 0; --k) {
        GDALDriverH driver = g.GDALGetDriver(k);
        const std::string name = g.GDALGetDriverShortName(driver);
        if (std::find(std::begin(drivers), std::end(drivers), name) != std::end(drivers)) continue;
        g.GDALDeregisterDriver(driver);
        g.GDALDestroyDriver(driver);
    }
    return g;
}

}  // namespace

bool has_gdal() {
    return true;
}

const GdalLibrary& gdal() {
    static const GdalLibrary library = load();
    return library;
}

std::string gdal_message() {
    std::string text = gdal().CPLGetLastErrorMsg();
    for (char& c : text)
        if (c == '\n') c = ' ';
    return text.empty() ? "GDAL gives no reason" : text;
}

namespace {

/// WKT, or a code of EPSG. GDAL would follow links and open files as well.
bool is_definition(const std::string& text) {
    if (text.starts_with("EPSG:")) return true;
    const std::size_t word = text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_");
    return word != 0 && word != std::string::npos && text[word] == '[';
}

}  // namespace

GdalSystem system_of(const std::string& text) {
    if (!is_definition(text)) return nullptr;
    GdalSystem system(gdal().OSRNewSpatialReference(nullptr));
    if (gdal().OSRSetFromUserInput(system.get(), text.c_str()) != OGRERR_NONE) return nullptr;
    gdal().OSRSetAxisMappingStrategy(system.get(), OAMS_TRADITIONAL_GIS_ORDER);
    return system;
}

std::string wkt_of(OGRSpatialReferenceH system) {
    if (!system) return {};
    char* text = nullptr;
    const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
    const bool good = gdal().OSRExportToWktEx(system, &text, options) == OGRERR_NONE && text;
    std::string wkt = good ? text : "";
    gdal().VSIFree(text);
    return wkt;
}

std::string name_of(OGRSpatialReferenceH system) {
    const char* name = gdal().OSRGetName(system);
    const char* authority = gdal().OSRGetAuthorityName(system, nullptr);
    const char* code = gdal().OSRGetAuthorityCode(system, nullptr);
    std::string text = name ? name : "a system without a name";
    if (authority && code) text += fmt::format(" ({}:{})", authority, code);
    return text;
}

GdalDataset open_gis_file(const std::string& path, const std::string& kind, const std::string& key, unsigned flags) {
    std::error_code none;
    const std::string problem = fmt::format("the {} cannot be read", kind), remedy = fmt::format("Is {} right?", key);
    if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none))
        refuse(path, problem, "it is not a regular file", remedy);
    if (!std::ifstream(path, std::ios::binary)) refuse(path, problem, "no such file or no permission", remedy);
    check_source(path);
    gdal().CPLErrorReset();
    GdalDataset dataset(gdal().GDALOpenEx(path.c_str(), flags | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
    if (!dataset)
        refuse(path, problem, gdal_message(),
               "Is it complete, and GeoTIFF, ESRI ASCII grid, netCDF, GeoPackage, shapefile or GeoJSON?");
    return dataset;
}

std::string bytes_in_memory(const std::string& name) {
    vsi_l_offset size = 0;
    const GByte* bytes = gdal().VSIGetMemFileBuffer(name.c_str(), &size, FALSE);
    if (!bytes) throw MachineError(fmt::format("GDAL did not write {} ({}).", name, gdal_message()));
    std::string text(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
    gdal().VSIUnlink(name.c_str());
    return text;
}

}  // namespace moraine
