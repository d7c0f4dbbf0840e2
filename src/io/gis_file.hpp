#pragma once
// Files of geographic information systems, by GDAL (https://gdal.org): GeoTIFF, ESRI ASCII grid and netCDF; polygons,
// lines and points of GeoPackage, shapefile or GeoJSON; their coordinate reference systems (CRS) by PROJ.
//
// No other driver of GDAL is left in the process: a file may come from anybody, and most drivers open what a text in it
// names, hosts of a network among it. A VRT may name files of its own folder.
//
// GDAL is no library of the program: it is loaded (dlopen) by the first call that needs it, so a scene without such
// files starts as fast as ever, and does so on machines that have no GDAL. A build without GDAL's headers has none of
// this, and says so. Rasters are never resampled or reprojected; vector data are reprojected to the model's CRS.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/structures/ground.hpp"

namespace moraine {

/// Whether this build has it.
bool has_gdal();

/// What a raster is, for messages: "terrain model" by terrain.dem of heights.
struct RasterUse {
    std::string kind = "terrain model", key = "terrain.dem", value = "height";
};

/// A part of a raster, in nodes.
struct NodeWindow {
    std::array<std::int64_t, 2> first{}, count{};
};

/// Reads the part of a raster that `window` wants, which is given place, spacing, size and CRS, but no values. Values
/// that the file does not know are NaN. `notices` gets what a user should know. Throws InputError.
Ground read_gis_raster(const std::string& path, const RasterUse& use,
                       const std::function<NodeWindow(const Ground&)>& window, std::vector<std::string>& notices);

/// Whether two systems are the same between `min` and `max` to `tolerance` [m]; one that is not known is any.
bool are_same_crs(const std::string& one, const std::string& other, const std::array<double, 2>& min,
                  const std::array<double, 2>& max, double tolerance);

/// The system that NAME.prj beside NAME.asc has; empty where there is none. Throws InputError.
std::string crs_beside(const std::string& path);

/// Refuses a model whose metres are not those of the ground to a per cent, by its projection: slopes would be wrong by
/// as much. Throws InputError.
void check_scale(const Ground& part, const std::string& path);

enum class GisKind { polygon, line, point };

/// One polygon (its outer ring, the first corner not again at the end), line or point.
struct GisShape {
    std::vector<std::array<double, 2>> points;
    std::string name;                 ///< attribute of this name; empty: none
    std::optional<double> thickness;  ///< the same [m]
};

/// All shapes of a file, reprojected to `crs` where both are known. `key`: who names the file. Throws InputError.
std::vector<GisShape> read_gis_shapes(const std::string& path, const std::string& key, GisKind kind,
                                      const std::string& crs, std::vector<std::string>& notices);

/// Words about a map, by name.
using MapTags = std::vector<std::pair<std::string, std::string>>;

/// A map as a tiled, compressed GeoTIFF.
struct MapImage {
    std::array<std::int64_t, 2> size{};
    std::array<double, 2> corner{};  ///< lower left [m]
    double cell = 0;                 ///< [m]
    std::string crs, name, unit;
    double no_data = -9999;
    std::function<void(std::int64_t, float*)> row;  ///< writes the values of a row, counted from the north
    MapTags tags{};
};
/// The bytes of the file. Throws MachineError.
std::string geotiff_bytes(const MapImage& image);

/// A polygon with holes: rings, the first the outer one.
using Rings = std::vector<std::vector<std::array<double, 2>>>;

/// The bytes of a GeoPackage of one layer "outline", whose feature has the threshold and the tags; the same of the same
/// polygons, at any time of day. Without a system it is on a plane. Throws MachineError.
std::string outline_bytes(const std::vector<Rings>& polygons, const std::string& crs, double threshold,
                          const MapTags& tags);

}  // namespace moraine
