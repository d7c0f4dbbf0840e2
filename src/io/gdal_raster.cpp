#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/error.hpp"
#include "io/gdal_library.hpp"
#include "io/gis_file.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

/// Place and spacing; `south_first`: rows run from south to north.
Ground shape_of(void* dataset, const std::string& path, bool& south_first) {
    const GdalLibrary& g = gdal();
    double t[6];
    if (g.GDALGetGeoTransform(dataset, t) != CE_None)
        refuse(path, "the raster has no place", "it says no corner and no size of a cell", "Is it georeferenced?");
    if (t[2] != 0 || t[4] != 0 || !(t[1] > 0) || !(std::fabs(std::fabs(t[5]) / t[1] - 1) <= 1e-6))
        refuse(path,
               fmt::format("cells of {:.6g} x {:.6g}, turned by {:.3g}, {:.3g}", t[1], std::fabs(t[5]), t[2], t[4]),
               "cells must be squares along x and y", "Resample it, by gdalwarp -tr?");
    south_first = t[5] > 0;
    Ground shape;
    shape.spacing = t[1];
    shape.count = {g.GDALGetRasterXSize(dataset), g.GDALGetRasterYSize(dataset)};
    shape.first[0] = t[0] + 0.5 * t[1];
    shape.first[1] = t[3] + (south_first ? 0.5 : 0.5 - static_cast<double>(shape.count[1])) * t[1];
    return shape;
}

/// Refuses what is not in metres.
void check_system(OGRSpatialReferenceH system, const std::string& path) {
    if (!system) return;
    const GdalLibrary& g = gdal();
    const std::string remedy = "Reproject it to a metric system, by gdalwarp -t_srs?";
    if (g.OSRIsGeographic(system)) refuse(path, "the raster is in degrees", name_of(system), remedy);
    char* unit = nullptr;
    if (g.OSRIsProjected(system) && std::fabs(g.OSRGetLinearUnits(system, &unit) - 1) > 1e-9)
        refuse(path, fmt::format("the raster is in {}", unit ? unit : "another unit"),
               fmt::format("{}; scenes are in metres", name_of(system)), remedy);
}

/// The one band, of a kind of number that can be a value.
GDALRasterBandH band_of(void* dataset, const std::string& path, const RasterUse& use,
                        std::vector<std::string>& notices) {
    const GdalLibrary& g = gdal();
    if (const int bands = g.GDALGetRasterCount(dataset); bands != 1)
        refuse(path, fmt::format("the raster has {} bands", bands), fmt::format("a {} has one", use.kind),
               "Extract the right one by gdal_translate -b?");
    GDALRasterBandH band = g.GDALGetRasterBand(dataset, 1);
    const GDALDataType type = g.GDALGetRasterDataType(band);
    const std::string unit = g.GDALGetRasterUnitType(band), name = g.GDALGetDataTypeName(type);
    static const std::vector<std::string> metres{"", "m", "metre", "metres", "meter", "meters"};
    if (use.value == "height" && std::find(metres.begin(), metres.end(), unit) == metres.end())
        refuse(path, "heights in " + quote(unit), "scenes are in metres", "Convert them?");
    if (name.starts_with("C")) refuse(path, "values of type " + name, "must be real numbers", "Is it the right file?");
    if (use.value == "height" && type != GDT_Float32 && type != GDT_Float64)
        notices.push_back(
            fmt::format("{}: heights are whole numbers ({}), taken as metres; slopes are steps.", path, name));
    return band;
}

/// Raw numbers into values: what is not known is NaN.
void scale_values(GDALRasterBandH band, const std::string& path, const RasterUse& use, Ground& part) {
    const GdalLibrary& g = gdal();
    int has_none = 0, has_scale = 0, has_offset = 0;
    const double none = g.GDALGetRasterNoDataValue(band, &has_none);
    const double scale = g.GDALGetRasterScale(band, &has_scale), offset = g.GDALGetRasterOffset(band, &has_offset);
    const bool single = g.GDALGetRasterDataType(band) == GDT_Float32;
    const auto is_none = [&](double z) {
        return has_none && (z == none || (single && static_cast<float>(z) == static_cast<float>(none)));
    };
    for (std::size_t k = 0; k < part.height.size(); ++k) {
        double& z = part.height[k];
        if (std::isnan(z) || is_none(z)) {
            z = std::numeric_limits<double>::quiet_NaN();
            continue;
        }
        if (has_scale) z *= scale;
        if (has_offset) z += offset;
        if (std::isfinite(z)) continue;
        const auto column = static_cast<double>(static_cast<std::int64_t>(k) % part.count[0]);
        const auto row = static_cast<double>(static_cast<std::int64_t>(k) / part.count[0]);
        refuse(path,
               fmt::format("the {} at ({:.10g}, {:.10g}) is infinite", use.value, part.first[0] + column * part.spacing,
                           part.first[1] + row * part.spacing),
               "must be a finite number", "Give such cells the no-data value?");
    }
}

}  // namespace

Ground read_gis_raster(const std::string& path, const RasterUse& use,
                       const std::function<NodeWindow(const Ground&)>& window, std::vector<std::string>& notices) {
    const GdalLibrary& g = gdal();
    const GdalDataset dataset = open_gis_file(path, use.kind, use.key, GDAL_OF_RASTER);
    GDALRasterBandH band = band_of(dataset.get(), path, use, notices);
    OGRSpatialReferenceH system = g.GDALGetSpatialRef(dataset.get());
    check_system(system, path);
    bool south_first = false;
    Ground part = shape_of(dataset.get(), path, south_first);
    part.crs = wkt_of(system);
    const std::int64_t rows = part.count[1];
    const NodeWindow w = window(part);
    for (std::size_t a = 0; a < 2; ++a) part.first[a] += static_cast<double>(w.first[a]) * part.spacing;
    part.count = w.count;
    const auto nx = static_cast<int>(w.count[0]), ny = static_cast<int>(w.count[1]);
    part.height.resize(static_cast<std::size_t>(w.count[0] * w.count[1]));
    const std::int64_t top = south_first ? w.first[1] : rows - w.first[1] - w.count[1];
    g.CPLErrorReset();
    if (g.GDALRasterIOEx(band, GF_Read, static_cast<int>(w.first[0]), static_cast<int>(top), nx, ny, part.height.data(),
                         nx, ny, GDT_Float64, 0, 0, nullptr) != CE_None)
        refuse(path, "the raster cannot be read", gdal_message(), "Is the file complete?");
    for (std::int64_t j = 0; j < w.count[1] / 2 && !south_first; ++j)
        std::swap_ranges(part.height.begin() + j * nx, part.height.begin() + (j + 1) * nx,
                         part.height.begin() + (w.count[1] - 1 - j) * nx);
    scale_values(band, path, use, part);
    return part;
}

bool are_same_crs(const std::string& one, const std::string& other, const std::array<double, 2>& min,
                  const std::array<double, 2>& max, double tolerance) {
    if (one.empty() || other.empty() || one == other) return true;
    const GdalSystem from = system_of(one), to = system_of(other);
    if (!from || !to) return true;
    if (gdal().OSRIsSame(from.get(), to.get())) return true;
    const GdalTransform transform(gdal().OCTNewCoordinateTransformation(from.get(), to.get()));
    if (!transform) return false;
    for (double px : {min[0], max[0]})
        for (double py : {min[1], max[1]}) {
            double x = px, y = py;
            if (!gdal().OCTTransform(transform.get(), 1, &x, &y, nullptr) || !(std::hypot(x - px, y - py) <= tolerance))
                return false;
        }
    return true;
}

std::string crs_beside(const std::string& path) {
    const std::string beside = std::filesystem::path(path).replace_extension(".prj").string();
    std::error_code none;
    if (!std::filesystem::is_regular_file(beside, none)) return {};
    const GdalSystem system = system_of(beside);  // a path is one way to name a system
    if (!system) refuse(beside, "no coordinate system", gdal_message(), "Remove the file, or mend it?");
    check_system(system.get(), beside);
    return wkt_of(system.get());
}

std::string geotiff_bytes(const MapImage& image) {
    const GdalLibrary& g = gdal();
    const std::string name = "/vsimem/moraine_map.tif";
    const auto nx = static_cast<int>(image.size[0]), ny = static_cast<int>(image.size[1]);
    char** options = nullptr;
    options = g.CSLSetNameValue(options, "TILED", "YES");
    options = g.CSLSetNameValue(options, "COMPRESS", "DEFLATE");
    GDALDriverH driver = g.GDALGetDriverByName("GTiff");
    GdalDataset dataset(driver ? g.GDALCreate(driver, name.c_str(), nx, ny, 1, GDT_Float32, options) : nullptr);
    g.CSLDestroy(options);
    if (!dataset) throw MachineError(fmt::format("GDAL cannot write GeoTIFF ({}).", gdal_message()));
    double place[6] = {image.corner[0], image.cell, 0, image.corner[1] + image.cell * static_cast<double>(ny), 0,
                       -image.cell};
    g.GDALSetGeoTransform(dataset.get(), place);
    if (const GdalSystem system = system_of(image.crs)) g.GDALSetSpatialRef(dataset.get(), system.get());
    for (const auto& [name_of_tag, value] : image.tags)
        g.GDALSetMetadataItem(dataset.get(), name_of_tag.c_str(), value.c_str(), nullptr);
    GDALRasterBandH band = g.GDALGetRasterBand(dataset.get(), 1);
    g.GDALSetRasterNoDataValue(band, image.no_data);
    g.GDALSetRasterUnitType(band, image.unit.c_str());
    g.GDALSetDescription(band, image.name.c_str());
    std::vector<float> row(static_cast<std::size_t>(nx));
    for (int j = 0; j < ny; ++j) {
        image.row(j, row.data());
        if (g.GDALRasterIOEx(band, GF_Write, 0, j, nx, 1, row.data(), nx, 1, GDT_Float32, 0, 0, nullptr) != CE_None)
            throw MachineError(fmt::format("GDAL cannot write a map ({}).", gdal_message()));
    }
    dataset.reset();
    return bytes_in_memory(name);
}

}  // namespace moraine
