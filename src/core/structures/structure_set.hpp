#pragma once
// All rigid structures of a run: where they are, and what they felt. The same values on all ranks; what they felt is
// what this rank's nodes gave, summed exactly, so that the sum over ranks does not depend on who owned the nodes.
//
//   prescribed   place and velocity follow from time alone (structure_motion.hpp)
//   free         M dV/dt = M g + F + contact, and where it turns dL/dt = moment about its centre of mass; the impulse
//   of
//                a step is felt in the next one
//
// The nodes of a step must know how fast a free structure will be at its end, before the impulse J of that step is
// known. They take V* = V + J*/M with the impulse of the step before, corrected for what V* itself changes in it,
//   J* = J' - K (V* - V*'),  K: mass of the nodes that follow it (contact.hpp),
// so that a structure at rest on soil does not creep and a light one does not recoil too far. V itself is exact. One
// that turns has V and w together, and K with what couples them (core/structures/rigid_body.hpp). Impulses between
// structures (core/structures/collisions.hpp) are felt at once, by V* and by V.

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/structures/collisions.hpp"
#include "core/structures/contact.hpp"
#include "core/structures/rigid_body.hpp"
#include "core/structures/structure_motion.hpp"

namespace moraine {

/// What changes with time; a checkpoint keeps it.
template <int Dim>
struct StructureState {
    Vec<double, Dim> displacement = zero_vec<double, Dim>();  ///< since the start [m]
    Vec<double, Dim> velocity = zero_vec<double, Dim>();      ///< of the last step, as the soil saw it: V* [m/s]
    Vec<double, Dim> carried = zero_vec<double, Dim>();       ///< free: V by all that was felt up to it [m/s]
    Rotation<Dim> turned;                                     ///< since the start
    Vec<double, moments<Dim>> spin = zero_vec<double, moments<Dim>>();  ///< of the last step, likewise w* [rad/s]
    Vec<double, moments<Dim>> carried_spin = zero_vec<double, moments<Dim>>();  ///< free: L, likewise [kg m2/s]
    TurningSums<Dim> pending_turning;                                           ///< of those that are free and turn
    StructureSums<Dim> pending;   ///< of the last step: not felt yet (free ones)
    StructureSums<Dim> felt;      ///< of all steps
    StructureSums<Dim> reported;  ///< felt at the last row of the records
};

/// The components that a scene of this dimension has.
template <int Dim>
Vec<double, Dim> vec_of(const Triple& t) {
    Vec<double, Dim> v;
    for (int a = 0; a < Dim; ++a) v[a] = t[static_cast<std::size_t>(a)];
    return v;
}

template <int Dim>
class StructureSet {
  public:
    explicit StructureSet(const Scene& scene);

    bool empty() const { return values_.empty(); }
    bool any_free() const { return any_free_; }
    bool any_moves() const { return any_moves_; }
    bool any_turns() const { return any_turns_; }
    std::size_t size() const { return values_.size(); }
    std::size_t corners() const { return corners_.size(); }
    std::span<const SoilShare> soil() const { return soil_; }
    const StructureSpec& spec(std::size_t k) const { return scene_.structures[k]; }
    const StructureState<Dim>& state(std::size_t k) const { return states_[k]; }
    std::vector<StructureState<Dim>>& states() { return states_; }
    double reported_time = 0;  ///< of the last row of the records [s]

    /// Places at the start of a step, from which its gaps are taken, and velocities of the step before.
    void place();
    /// Velocities of the step that begins at `time`, with its gravity [m/s2]; `pending` and `turning` are sums over all
    /// ranks (free structures only, and those that turn).
    void begin_step(double time, double dt, const std::array<double, Dim>& gravity,
                    std::span<const StructureSums<Dim>> pending, const Quantum& quantum,
                    std::span<const TurningSums<Dim>> turning = {});
    /// Places at the end of the step.
    void end_step(double time, double dt);
    /// Adds up what this rank's nodes gave in a step; `turning`: empty where no structure turns.
    void take(std::span<const StructureSums<Dim>> mine, std::span<const TurningSums<Dim>> turning = {});
    void forget_pending();
    /// Nothing where no structure meets others.
    std::optional<Collisions<Dim>>& collisions() { return collisions_; }

    /// For the kernels: everything but where the sums go. Pointers are to this set.
    ContactField<Dim> field() const;

  private:
    void prescribe(std::size_t k, double time, double dt);
    void begin_free(std::size_t k, double dt, const std::array<double, Dim>& gravity, const StructureSums<Dim>& pending,
                    const Quantum& quantum);
    void begin_turning(std::size_t k, double dt, const std::array<double, Dim>& gravity,
                       const StructureSums<Dim>& pending, const TurningSums<Dim>& turning, const Quantum& quantum);

    /// What free structures give each other in the step, once they know what soil gave them.
    void collide(double dt, std::span<const StructureSums<Dim>> pending, const Quantum& quantum,
                 std::span<const TurningSums<Dim>> turning);
    Mat<double, CollidingBody<Dim>::axes> answer_of(std::size_t k, const StructureSums<Dim>& pending,
                                                    const Quantum& quantum,
                                                    std::span<const TurningSums<Dim>> turning) const;
    void take_collision(std::size_t k);

    const Scene& scene_;
    std::vector<Structure<Dim>> values_;
    std::vector<Vec<double, Dim>> start_;  ///< Structure::at at the start
    std::vector<Vec<double, 2>> corners_;
    std::vector<SoilShare> soil_;  ///< by body; empty: no interface follows the soil
    std::vector<StructureState<Dim>> states_;
    std::vector<RigidBody<Dim>> bodies_;  ///< of those that are free and turn
    std::optional<Collisions<Dim>> collisions_;
    std::vector<CollidingBody<Dim>> colliding_;  ///< of this step; empty: none meets others
    bool any_free_ = false, any_moves_ = false, any_turns_ = false;
};

}  // namespace moraine
