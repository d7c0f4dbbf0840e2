#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/data/error.hpp"
#include "io/file_numbers.hpp"
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
    if (use.value == "height" && std::find(metres.begin(), metres.end(), lower_case(unit)) == metres.end())
        refuse(path, "heights in " + quote(unit), "scenes are in metres", "Convert them?");
    if (name.starts_with("C")) refuse(path, "values of type " + name, "must be real numbers", "Is it the right file?");
    if (name.ends_with("Int64"))
        refuse(path, "values of type " + name, "its no-data value is not read",
               "Convert it, by gdal_translate -ot Float64?");
    const char* positive = g.GDALGetMetadataItem(band, "positive", nullptr);
    if (use.value == "height" && positive && lower_case(positive) == "down")
        refuse(path, "its values count down", "positive = \"down\"; scenes have z up", "Turn their sign?");
    if (use.value == "height" && type != GDT_Float32 && type != GDT_Float64)
        notices.push_back(
            fmt::format("{}: heights are whole numbers ({}), taken as metres; slopes are steps.", path, name));
    return band;
}

/// What else than its no-data value stands for none in a band: values that netCDF names.
std::vector<double> further_no_data(GDALRasterBandH band) {
    std::vector<double> all;
    for (const char* key : {"_FillValue", "missing_value"})
        if (const char* text = gdal().GDALGetMetadataItem(band, key, nullptr))
            if (const auto value = number_in(text)) all.push_back(*value);
    return all;
}

/// What a mask of its own hides is not known.
void apply_mask(GDALRasterBandH band, const std::string& path, const std::array<int, 2>& first, Ground& part) {
    const GdalLibrary& g = gdal();
    const int flags = g.GDALGetMaskFlags(band), mask_and_alpha = GMF_PER_DATASET | GMF_ALPHA;
    if (!(flags & mask_and_alpha)) return;
    const auto nx = static_cast<int>(part.count[0]), ny = static_cast<int>(part.count[1]);
    std::vector<double> shown(part.height.size());
    if (g.GDALRasterIOEx(g.GDALGetMaskBand(band), GF_Read, first[0], first[1], nx, ny, shown.data(), nx, ny,
                         GDT_Float64, 0, 0, nullptr) != CE_None)
        refuse(path, "the raster's mask cannot be read", gdal_message(), "Is the file complete?");
    for (std::size_t k = 0; k < shown.size(); ++k)
        if (shown[k] == 0) part.height[k] = std::numeric_limits<double>::quiet_NaN();
}

/// Raw numbers into values: what is not known is NaN.
void scale_values(GDALRasterBandH band, const std::string& path, const RasterUse& use, Ground& part) {
    const GdalLibrary& g = gdal();
    int has_none = 0, has_scale = 0, has_offset = 0;
    const double none = g.GDALGetRasterNoDataValue(band, &has_none);
    const double scale = g.GDALGetRasterScale(band, &has_scale), offset = g.GDALGetRasterOffset(band, &has_offset);
    const std::vector<double> more = further_no_data(band);
    const auto is_none = [&](double z) {
        return is_no_data(z, has_none ? std::optional(none) : std::nullopt) ||
               std::any_of(more.begin(), more.end(), [&](double value) { return is_no_data(z, value); });
    };
    for (std::size_t k = 0; k < part.height.size(); ++k) {
        double& z = part.height[k];
        if (is_none(z)) {
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
    apply_mask(band, path, {static_cast<int>(w.first[0]), static_cast<int>(top)}, part);
    for (std::int64_t j = 0; j < w.count[1] / 2 && !south_first; ++j)
        std::swap_ranges(part.height.begin() + j * nx, part.height.begin() + (j + 1) * nx,
                         part.height.begin() + (w.count[1] - 1 - j) * nx);
    scale_values(band, path, use, part);
    return part;
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
