#pragma once
// How sharply the ground bends, and a ground that bends less.
//
//   k = |M| + (M^2 - K)^(1/2): the larger principal curvature of z = b(x, y) by mean and Gaussian curvature,
//   M = ((1 + b_y^2) b_xx - 2 b_x b_y b_xy + (1 + b_x^2) b_yy) / (2 (1 + |grad b|^2)^(3/2)),
//   K = (b_xx b_yy - b_xy^2) / (1 + |grad b|^2)^2
//
// at the nodes of the model, of the spline through them. A bend of a radius below some cells is more than the grid
// resolves: soil jumps over it or rests on its edge. Heights where k is too large, and those next to them, are relaxed
// towards the mean of their neighbours until it is not; planes stay, and all that bends little enough.

#include "core/structures/ground.hpp"

namespace moraine {

/// 1 / k [m], the least over the nodes; infinite of planes. The table must be there.
double least_radius(const Ground& ground);

/// Makes the table, and until the least radius is at least `radius` changes heights. Returns the largest change [m];
/// NaN if the heights do not come there.
double smooth_ground(Ground& ground, double radius);

}  // namespace moraine
