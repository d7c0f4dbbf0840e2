#pragma once
// The energy budget on the host (core/nodes/node_energy.hpp), where a scene wants it: what the nodes did, what left,
// and what soil that is put out of a structure sets free. Not collective.

#include <array>
#include <vector>

#include "blocks/contact_pairs.hpp"
#include "blocks/patch.hpp"
#include "core/nodes/node_energy.hpp"
#include "core/transfer/method.hpp"
#include "engine/engine.hpp"

namespace moraine {

template <class Real, int Dim>
class HostEnergy {
  public:
    /// All must outlive it.
    HostEnergy(const Scene& scene, const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch)
        : scene_(scene), method_(method), patch_(patch) {}

    bool is_counted() const { return scene_.output.energy_budget; }

    /// Of the particles of each block with pairs, in list order, at its first pair [J].
    std::vector<double> potentials_of(const std::vector<ContactPair>& pairs, const std::array<double, Dim>& gravity);
    /// Soil that is too deep in a structure was put out of it: places alone change
    /// (core/structures/particle_depth.hpp).
    void note_put_out(const std::vector<double>& before, const std::vector<double>& after);
    /// Adds what nodes and structures of a round did; `moved`: particles have been moved by it.
    void record(const StepScales<Dim>& step, bool moved, EnergyAccount& account);

    /// What a solution of so many node blocks does.
    NodeEnergy* of_nodes(std::size_t count) { return nodes_.resize(count), nodes_.data(); }
    NodeEnergy* of_nodes() { return nodes_.data(); }

  private:
    double potential_of(int block, std::uint32_t slot, const std::array<int, Dim>& carry,
                        const std::array<double, Dim>& gravity);
    void count_lost(const StepScales<Dim>& step, EnergyAccount& account);

    const Scene& scene_;
    const Method<Host, Real, Dim>& method_;
    Patch<Host, Real, Dim>& patch_;
    Host::Array<NodeEnergy> nodes_;
    std::vector<double> put_out_;  ///< potential energy that blocks set free in this step [J]
};

}  // namespace moraine
