#pragma once
// Where a flow has been, as polygons: the 4-connected parts of the map cells that it reached, each an outer ring
// (counter-clockwise) and its holes (clockwise), corners where the border turns. Rings touch themselves nowhere: cells
// that share a corner only belong to two rings that meet there, as the formats of maps want it. The order follows
// from the cells alone.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/gis_file.hpp"

namespace moraine {

/// Column and row of a cell of a map, or of its lower left corner.
using PlanCell = std::array<std::int64_t, 2>;

/// Where the cells of a map are.
struct PlanGrid {
    PlanCell size;                     ///< cells
    std::array<double, 2> corner;      ///< of the map [m]
    double cell;                       ///< [m]
    std::array<double, 2> begin, end;  ///< of the first and of the last cell [m]
};

/// `reached`: each cell once, in any order.
std::vector<Rings> outline_of(std::vector<PlanCell> reached, const PlanGrid& grid);

/// As GeoJSON, in the coordinates of the model.
std::string outline_json(const std::vector<Rings>& polygons, double threshold);

}  // namespace moraine
