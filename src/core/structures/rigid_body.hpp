#pragma once
// Mass, centre and inertia of a structure that is free, and how it turns in a step.
//
//   (M + K) x* = p + J' + K x*',   x = (V, w),  p = (m V, L),  M = diag(m, R I R^T)         what soil will see
//   L* = R I R^T w*;  R goes on by the flow of the free top with L*                         in 3-D
//
// K: how much less the soil gives to what moves faster (core/structures/structure_set.hpp has the reasons), with what
// moving does to turning and the other way round. p takes the impulses themselves, so that momentum and angular
// momentum are exact, and L stays what it is where nothing acts.
//
// The free top by rotations about its three axes of inertia in turn, e1 e2 e3 e2 e1 with half, half, whole, half, half
// of the step, each by what L has along it over its inertia (Touma and Wisdom 1994; Dullweber, Leimkuhler and McLachlan
// 1997, J. Chem. Phys. 107, 5840): symplectic, |L| to rounding, energy without a drift. Five such steps, of which the
// middle one goes back, are of fourth order (Suzuki 1990). An explicit step of Euler's equations would gain energy;
// Jacobi's functions, which are exact, are more than steps of soil ask for.

#include "core/scene_spec.hpp"
#include "core/structures/contact_field.hpp"
#include "core/structures/rotation.hpp"

namespace moraine {

/// In its own axes, those of the scene at the start.
template <int Dim>
struct RigidBody {
    double mass = 0;                  ///< [kg]
    Vec<double, moments<Dim>> about;  ///< principal inertia about the centre [kg m2]
    Rotation<Dim> axes;               ///< from the axes of inertia to its own

    /// R I R^T [kg m2]; turned: R.
    Mat<double, moments<Dim>> inertia(const Rotation<Dim>& turned) const;
    /// The turn of a step of dt [s], with the angular momentum L [kg m2/s], of one that is turned.
    Rotation<Dim> turn(const Rotation<Dim>& turned, const Vec<double, moments<Dim>>& L, double dt) const;
};

/// What a free structure brings to a step, and what the soil gave it in the step before.
template <int Dim>
struct FreeMotion {
    static constexpr int axes = TurningSums<Dim>::axes;
    Vec<double, axes> momentum;                    ///< p, with J' [kg m/s, kg m2/s]
    Vec<double, axes> impulse;                     ///< J'
    Vec<double, axes> seen;                        ///< x*' [m/s, rad/s]
    Vec<double, TurningSums<Dim>::count> follows;  ///< K
};

/// M + K of a body that is turned, by the upper half of K, row by row.
template <int Dim>
Mat<double, FreeMotion<Dim>::axes> followed_mass(const RigidBody<Dim>& body, const Rotation<Dim>& turned,
                                                 const Vec<double, TurningSums<Dim>::count>& follows);
/// Of a matrix that is symmetric and positive definite.
template <int N>
Mat<double, N> inverse_mass(Mat<double, N> all);

/// x*, of a body that is turned.
template <int Dim>
Vec<double, FreeMotion<Dim>::axes> expected_motion(const RigidBody<Dim>& body, const Rotation<Dim>& turned,
                                                   const FreeMotion<Dim>& motion);

/// Area or volume of a structure that has one, else 0 [m2, m3].
double volume_of(const StructureSpec& spec, int dimensions);

/// Of one that has such, at the start [m].
template <int Dim>
Vec<double, Dim> centre_of_mass(const StructureSpec& spec);

/// Of a structure with an end on all sides; by its own keys where they say so.
template <int Dim>
RigidBody<Dim> rigid_body(const StructureSpec& spec);

}  // namespace moraine
