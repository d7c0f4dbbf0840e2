#pragma once
// Terrain models and polygons from files.
//
//   .asc      ESRI ASCII grid: ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize, NODATA_value if
//             wanted; then the heights [m], rows from north to south. A height is that of the middle of its cell.
//   .csv      profile: a header line x,z (z is up also where a scene in 2-D calls it y) and rows at even distances;
//             polygon: a header line x,y and a row per corner; points: a header line name,x,y;
//             inflow: a header line time,discharge,speed
//   .geojson  polygon: the outer ring of the first Polygon (or MultiPolygon of one), in the coordinates of the model;
//             line: the LineString
//
// Nothing is reprojected here: all must be in metres and in the coordinates of the scene (io/gis_file.hpp reads other
// formats). Not collective.

#include <array>
#include <string>
#include <vector>

#include "core/structures/ground.hpp"
#include "io/gis_file.hpp"

namespace moraine {

inline constexpr double most_heights = 268435456;  ///< 2^28 of a model that are kept: 6.4 GB on each rank

/// Heights that the file does not know are NaN. Throws InputError with file, line, reason and remedy.
Ground read_ascii_grid(const std::string& path, const RasterUse& use = {});
Ground read_profile(const std::string& path);

/// Corners of a polygon, the first not again at the end. Throws InputError.
std::vector<std::array<double, 2>> read_polygon(const std::string& path, const std::string& key = "release.area");

/// Points with their names. Throws InputError.
std::vector<GisShape> read_points(const std::string& path, const std::string& key);

/// Rows of an inflow's table. Throws InputError.
std::vector<std::array<double, 3>> read_hydrograph(const std::string& path, const std::string& key);

/// Times and values of a table of time, rising from 0 on. Throws InputError with the line.
std::vector<std::array<double, 2>> read_time_table(const std::string& path, const std::string& key);

/// The one line of a GeoJSON, without its name. Throws InputError.
GisShape read_line(const std::string& path, const std::string& key);

}  // namespace moraine
