#pragma once
// Ground: heights at the nodes of a terrain model (2-D: of a profile), and the quadratic B-spline through them.
//
//   b(x, y) = sum_ij c_ij N(x / a - i) N(y / a - j),    (c_{i-1} + 6 c_i + c_{i+1}) / 8 = b_i along each axis in turn
//
// N: the quadratic B-spline, a: spacing of the nodes. b and its slope are continuous, so a normal turns without jumps,
// which bilinear heights would make of every edge. Beyond the last node c goes on in a line: planes are exact.
// Kernels read it as a table (core/structures/ground_table.hpp).

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/structures/ground_table.hpp"

namespace moraine {

struct Ground {
    std::array<double, 2> first{};            ///< place of node (0, 0) [m]
    double spacing = 0;                       ///< a [m]
    std::array<std::int64_t, 2> count{1, 1};  ///< nodes along x and y; a profile has one row
    std::vector<double> height;               ///< x fastest, y rising [m]
    std::vector<double> friction, xi, su;     ///< of the bed at the nodes [-, m/s2, Pa]; empty: one value everywhere
    std::array<double, 2> whole{};            ///< place of node (0, 0) of the whole model, of which this is a part [m]
    std::string crs;                          ///< coordinate system, as WKT; empty: not known
    std::vector<Vec<double, 2>> table;        ///< by fit()

    /// Makes the table; all heights must be finite.
    void fit();
};

/// Appends a table of values at the nodes, whose edges go on beyond the last node.
void append_bed(const Ground& ground, const std::vector<double>& values, std::vector<Vec<double, 2>>& table);

/// Between the nodes of a raster, linear along both axes; nodes that are not known (NaN) are left out, and beyond the
/// outer nodes the edge goes on for half a cell. NaN where nothing is known.
double raster_value(const Ground& raster, double x, double y);

}  // namespace moraine
