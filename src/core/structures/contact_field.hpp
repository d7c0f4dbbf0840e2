#pragma once
// All structures of a scene as kernels see them: where they are, in the grid's terms, and where it is added up what
// they feel. Contact at the nodes (contact.hpp) and the gaps of particles (particle_gaps.hpp) read it.

#include "core/data/exact_sum.hpp"
#include "core/structures/structure.hpp"

namespace moraine {

template <int Dim>
inline constexpr int moments = Dim == 2 ? 1 : 3;

/// What the soil gave to one structure in one step: impulse [N s], moment of impulse about its reference point, per
/// axis the mass of the nodes that follow the structure there [kg]: how much more it would have got had it been faster,
/// and the work on it, impulse times velocity [J].
template <int Dim>
struct StructureSums {
    static constexpr int first_mass = Dim + moments<Dim>;
    static constexpr int work = first_mass + Dim;
    static constexpr int count = work + 1;
    ExactSum sum[count];

    void add(const StructureSums& o) {
        for (int k = 0; k < count; ++k) sum[k].add(o.sum[k]);
    }
};

/// What the soil of a body bears at an interface that follows it, of the greatest su of the scene: a scalar of its law
/// times `share`, or `share` alone.
struct SoilShare {
    int scalar = -1;   ///< -1: none
    double share = 0;  ///< [1/Pa] or [-]
};

/// All structures as a kernel sees them, and where it adds up what they feel.
template <int Dim>
struct ContactField {
    const Structure<Dim>* structure;
    int count;
    const Vec<double, 2>* corners;  ///< of all polygons
    Vec<double, Dim> origin;        ///< place of node 0 [m]
    Vec<double, Dim> period;        ///< of periodic axes, else 0 [m]
    const SoilShare* soil;          ///< by body; null: no interface follows the soil
    double cell;                    ///< h [m]
    double offset;                  ///< binning coordinate of node 0 (Stencil::offset) [cells]
    StructureSums<Dim>* sums;       ///< by structure; shared
    GroundNode<Dim>* ground;        ///< of the nodes of all node blocks; null: none is kept
};

MORAINE_HD double ramp(double x, double one, double zero) {
    const double t = (zero - x) / (zero - one);
    return t < 0 ? 0 : (t > 1 ? 1 : t);
}

/// x, or its periodic image nearest to the structure.
template <int Dim>
MORAINE_HD Vec<double, Dim> image_near(const ContactField<Dim>& f, const Structure<Dim>& s, Vec<double, Dim> x) {
    using std::rint;
    for (int a = 0; a < Dim; ++a)
        if (f.period[a] > 0) x[a] -= f.period[a] * rint((x[a] - s.at[a]) / f.period[a]);
    return x;
}

template <int Dim>
MORAINE_HD Vec<double, Dim> node_place(const ContactField<Dim>& f, const Structure<Dim>& s, const int* node,
                                       double shift) {
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = f.origin[a] + f.cell * (node[a] + shift);
    return image_near(f, s, x);
}

}  // namespace moraine
