#pragma once
// Where two rigid structures touch or soon may: points with a normal and a gap.
//
//   sphere with any shape     one point, by the distance of the other from its centre
//   prism with half a space   its corners (plane, wall, ground)
//   prism with prism          the axis along which they are furthest apart, among the normals of faces and in 3-D the
//                             cross products of edges (separating axes; Gottschalk, Lin and Manocha 1996); across a
//                             face the other's opposite face, clipped to its sides (Sutherland and Hodgman 1974);
//                             across two edges the nearest points of their lines
//
// Prism: a box, or a convex polygon. Distances from corners alone would do without the search, but give two edges'
// mean as the normal where corners of equal boxes meet, and miss edges that cross.

#include <array>
#include <vector>

#include "core/structures/structure.hpp"

namespace moraine {

template <int Dim>
struct ContactPoint {
    Vec<double, Dim> at;      ///< half way between the two [m]
    Vec<double, Dim> normal;  ///< from the first to the second
    double gap;               ///< negative: they overlap [m]
};

/// From its middle to its furthest point; infinite for planes and ground [m]. corners: of all polygons.
template <int Dim>
double reach_of(const Structure<Dim>& s, const Vec<double, 2>* corners);

/// Appends the points of two structures whose gap is at most `margin` [m], in an order that follows from the two alone.
/// The first is a sphere or a prism; the second one too, or of any shape if the first is a sphere, or half a space.
template <int Dim>
void find_contact_points(const Structure<Dim>& a, const Structure<Dim>& b, const Vec<double, 2>* corners, double margin,
                         std::vector<ContactPoint<Dim>>& points);

/// Whether no corner of it points inwards.
bool is_convex(const std::vector<std::array<double, 2>>& polygon);

}  // namespace moraine
