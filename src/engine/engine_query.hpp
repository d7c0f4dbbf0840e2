#pragma once
// Questions about the particles of one rank, answered where they are: on a device only the answer goes to the host.

#include <array>
#include <variant>
#include <vector>

#include "core/data/exact_sum.hpp"
#include "core/data/plan_samples.hpp"
#include "core/fluid/over_filling.hpp"
#include "core/nodes/absorbing_ends.hpp"

namespace moraine {

/// Adds to each column of a map the layers in which this rank has particles. Scenes in 3-D. Not collective.
struct LayerQuery {
    const PlanColumns& columns;
    std::vector<Layers>& layers;
};

/// Adds the particles of this rank to the sums of a map's columns. Scenes in 3-D. Not collective.
struct ColumnQuery {
    const PlanColumns& columns;
    std::vector<std::int64_t>& sums;
    double square_speed = 0;  ///< answer: the largest |v|^2 of all [m2/s2]
};

/// The particles of this rank near lines, which are the same in all queries. Scenes in 3-D. Not collective.
struct LineQuery {
    const PlanLines& lines;
    std::vector<NearParticle> near;  ///< answer, in any order
};

/// Volumes at the nodes that this rank counts. Collective over peers.
struct VolumeQuery {
    NodeVolumes volumes;  ///< answer
};

/// What a change of gravity works on the particles of this rank (core/gravity.hpp). Between binning and the gather of a
/// step. Not collective.
template <int Dim>
struct GravityQuery {
    PlanPlaces places;
    std::array<double, Dim> change;  ///< [m/s2]
    Quantum quantum;
    ExactSum work;  ///< answer [J]
};

/// A particle that went wrong.
template <int Dim>
struct FaultRecord {
    std::uint64_t id;
    std::uint32_t faults;
    std::array<double, Dim> x;  ///< [m]
};

/// The first particle of each block with faults, or of the share. Not collective.
template <int Dim>
struct FaultQuery {
    std::vector<FaultRecord<Dim>> found;  ///< answer
};

/// Absorbing ends are measured: all of the scene's at the nodes of those that are `asked`
/// (core/nodes/absorbing_ends.hpp). Asked of the host's engine alone. Collective over peers.
template <int Dim>
struct EndQuery {
    /// Of one face.
    struct Face {
        bool absorbs = false, asked = false;
        double p = 0, s = 0;  ///< impedance of what is behind it, rho c_p and rho c_s; both 0: the soil's own [kg/m2s]
    };
    std::array<std::array<Face, 2>, Dim> face{};
    std::array<double, Dim> gravity{};  ///< [m/s2]
    double mass_cutoff = 0;             ///< [kg]
    EndNodes<Dim> found;                ///< answer: nodes that this rank counts, in any order
};

template <int Dim>
using EngineQuery = std::variant<LayerQuery*, ColumnQuery*, LineQuery*, VolumeQuery*, GravityQuery<Dim>*,
                                 FaultQuery<Dim>*, EndQuery<Dim>*>;

}  // namespace moraine
