#pragma once
// Structures that meet one another and walls: unilateral contact with Coulomb's friction and Newton's restitution, by
// impulses at the points of contact_points.hpp (Moreau 1988; Jean 1999, the contact dynamics method).
//
//   v_n >= b,  P_n >= 0,  P_n (v_n - b) = 0        b = -gap / dt, or -e v_n' where they would touch while they approach
//   |P_t| <= mu P_n, and opposite to v_t where they slide
//
// v is relative, at the end of the step, v' that of the step before, without this step's gravity: what rests does not
// bounce, and no speed has to be named below which e is zero. The impulses of all points are found together by sweeps
// of Gauss and Seidel, forwards and backwards by turns (sequential impulses; Catto 2005), that begin with those of the
// step before. What a structure answers to an impulse is what soil that follows it lets it: (M + K)^-1
// (core/structures/rigid_body.hpp); what it gets is the impulse itself, both of a pair the same one at one point, so
// that momentum and angular momentum are exact.
//
// Overlaps, which are of second order in dt, are taken out by the same sweeps over ways instead of velocities: they
// move structures, and give them no speed. Springs would be simpler, but stiff ones set the step, and soft ones sink.
//
// All ranks do the same in the same order, so the answer does not know them.

#include <span>
#include <vector>

#include "core/scene_spec.hpp"
#include "core/structures/contact_field.hpp"
#include "core/structures/contact_points.hpp"

namespace moraine {

/// A structure in a step, as what it meets finds it. (V, w): velocity and angular velocity [m/s, rad/s].
template <int Dim>
struct CollidingBody {
    static constexpr int axes = Dim + moments<Dim>;
    Vec<double, axes> before = zero_vec<double, axes>();   ///< in the step before; prescribed: in this one
    Vec<double, axes> motion = zero_vec<double, axes>();   ///< in this one; solve() adds to it
    Mat<double, axes> answer = {};                         ///< (M + K)^-1 [1/kg, ..]; zero: prescribed
    Vec<double, axes> impulse = zero_vec<double, axes>();  ///< what solve() gave it [N s, N m s]
    Vec<double, axes> way = zero_vec<double, axes>();      ///< and by which way it took it out of others [m, rad]
};

/// An impulse of a step, with which the next one begins.
template <int Dim>
struct ContactImpulse {
    std::array<int, 3> place;  ///< which pair of structures, periodic image, and point of theirs
    Vec<double, Dim> value;    ///< across and along [N s]
};

/// Whether a structure of a scene meets others and walls.
bool collides(const StructureSpec& s);
/// Whether two structures do so with each other.
bool collide(const StructureSpec& a, const StructureSpec& b);

/// Whether a face of the domain is a wall to them.
bool meets_structures(const WallSpec& wall);

template <int Dim>
class Collisions {
  public:
    /// Walls count as structures behind those of the scene.
    explicit Collisions(const Scene& scene);

    /// Impulses of a step of dt [s] between structures that stand at their places; bodies: of all of them.
    void solve(std::span<const Structure<Dim>> structures, std::vector<CollidingBody<Dim>>& bodies,
               const Vec<double, 2>* corners, double dt);
    /// Two that overlap by more than rounding, and by how much [m]; wall: 2 axis + (upper ? 1 : 0), or -1.
    struct Overlap {
        int first = -1, second = -1, wall = -1;
        double depth = 0;
    };
    Overlap worst_overlap(std::span<const Structure<Dim>> structures, const Vec<double, 2>* corners) const;

    /// For a checkpoint.
    std::vector<double> stored() const;
    /// Returns whether `all` can be what stored() gave in such a scene.
    bool restore(const std::vector<double>& all);

  private:
    struct Pair {
        int a, b;  ///< a is free and no half-space
        double friction, restitution;
    };
    /// A point, and what both answer to a unit impulse across (0) and along it.
    struct Row {
        int a, b;
        ContactImpulse<Dim> impulse;
        Vec<double, CollidingBody<Dim>::axes> arm_a[Dim], arm_b[Dim], answer_a[Dim], answer_b[Dim];
        Mat<double, Dim> answer, stick;  ///< G: the relative velocity by unit impulses, and its inverse [1/kg, kg]
        double gap, friction, bound;
        double slop;  ///< the overlap that is left [m]

        /// The impulse by which the law of contact holds, where without one the velocity would be `free` [m/s].
        Vec<double, Dim> lawful(const Vec<double, Dim>& free) const;
        /// The same of one that slides; way: of the impulse along the surface, of length 1.
        Vec<double, Dim> sliding(const Vec<double, Dim>& free, Vec<double, Dim> way) const;
    };

    /// f(a, b, pair, image, margin) of two structures that may be nearer than both their margins [m], one at its image.
    template <class F>
    void each_near(std::span<const Structure<Dim>> structures, std::span<const double> margins,
                   const Vec<double, 2>* corners, const F& f) const;
    void find_rows(std::span<const Structure<Dim>> structures, std::span<CollidingBody<Dim>> bodies,
                   const Vec<double, 2>* corners, double dt);
    Row row_of(const Pair& pair, const ContactPoint<Dim>& point, const Structure<Dim>& a, const Structure<Dim>& b,
               std::span<const CollidingBody<Dim>> bodies) const;
    void sweep(std::span<CollidingBody<Dim>> bodies, Vec<double, CollidingBody<Dim>::axes> CollidingBody<Dim>::*of,
               double enough);
    void part(std::span<CollidingBody<Dim>> bodies, double dt);

    std::vector<Pair> pairs_;
    std::vector<Structure<Dim>> walls_;
    std::vector<int> faces_;                 ///< of walls_
    Vec<double, Dim> period_;                ///< of periodic axes, else 0 [m]
    std::size_t structures_;                 ///< of the scene
    std::vector<Row> rows_;                  ///< of this step
    std::vector<ContactImpulse<Dim>> last_;  ///< of the step before
};

}  // namespace moraine
