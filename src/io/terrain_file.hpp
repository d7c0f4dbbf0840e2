#pragma once
// Terrain models and polygons from files.
//
//   .asc      ESRI ASCII grid: ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize, NODATA_value if
//             wanted; then the heights [m], rows from north to south. A height is that of the middle of its cell.
//   .csv      profile: a header line x,z (z is up also where a scene in 2-D calls it y) and rows at even distances;
//             polygon: a header line x,y and a row per corner
//   .geojson  polygon: the outer ring of the first Polygon (or MultiPolygon of one), in the coordinates of the model
//
// Nothing is reprojected: all must be in metres and in the coordinates of the scene. Not collective.

#include <array>
#include <string>
#include <vector>

#include "core/ground.hpp"

namespace moraine {

/// Heights that the file does not know are NaN. Throws InputError with file, line, reason and remedy.
Ground read_ascii_grid(const std::string& path);
Ground read_profile(const std::string& path);

/// Corners of a polygon, the first not again at the end. Throws InputError.
std::vector<std::array<double, 2>> read_polygon(const std::string& path);

/// The part of a model that the box from min to max needs, and some nodes around it where there are any. Throws
/// InputError where the model does not cover the box or does not know a height there; `path` is what messages name.
Ground cropped(const Ground& all, const std::string& path, const std::array<double, 2>& min,
               const std::array<double, 2>& max);

}  // namespace moraine
