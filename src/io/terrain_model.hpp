#pragma once
// What a scene takes of the files over which it runs: the part of a terrain model under its domain, rasters of other
// values there, and areas. By the name of a file: .asc, .csv and, where there is no GDAL, .geojson by terrain_file.hpp,
// all others by gis_file.hpp. Only the part that is wanted is kept, and of what GDAL reads only that is read.
//
// Not collective: every rank reads for itself.

#include "io/gis_file.hpp"

namespace moraine {

using PlanPoint = std::array<double, 2>;

/// The part of a model that the box from min to max needs, and some nodes around it where there are any, fitted. Throws
/// InputError where the model does not cover the box or does not know a height there.
Ground read_model(const std::string& path, const PlanPoint& min, const PlanPoint& max,
                  std::vector<std::string>& notices);

/// A box in plan: its lower and its upper corner.
using PlanBox = std::array<PlanPoint, 2>;

/// The same of a box that `under` lays by place, size and CRS of the model.
Ground read_model(const std::string& path, const std::function<PlanBox(const Ground&)>& under,
                  std::vector<std::string>& notices);

/// The same of a model in memory; `path` is what messages name.
Ground cropped(const Ground& all, const std::string& path, const PlanPoint& min, const PlanPoint& max);

/// Other values, of the part of the box that the raster has. Throws InputError where it has none, or where both have a
/// system of coordinates and the model's is another.
Ground read_values(const std::string& path, const RasterUse& use, const Ground& model, const PlanPoint& min,
                   const PlanPoint& max, std::vector<std::string>& notices);

/// Areas in the coordinates of the model. Throws InputError.
std::vector<GisShape> read_areas(const std::string& path, const std::string& key, const std::string& crs,
                                 std::vector<std::string>& notices);

/// Places with their names, in the coordinates of the model. Throws InputError.
std::vector<GisShape> read_places(const std::string& path, const std::string& key, const std::string& crs,
                                  std::vector<std::string>& notices);

/// Lines with their names, in the coordinates of the model. Throws InputError.
std::vector<GisShape> read_lines(const std::string& path, const std::string& key, const std::string& crs,
                                 std::vector<std::string>& notices);

}  // namespace moraine
