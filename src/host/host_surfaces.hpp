#pragma once
// What acts on surfaces where they are, on the host (Bed::surface): the pressure of cells that they cut, by what is
// open of their faces (surface_pressures.hpp), and contact, by elements (surface_forces.hpp). Both begin with the
// blocks near surfaces (surface_blocks.hpp), whose sums travel by themselves.

#include "host/surface_forces.hpp"

namespace moraine {

template <class Real, int Dim>
struct HostSurfaces {
    SurfaceBlocks<Real, Dim> blocks;
    SurfacePressures<Real, Dim> cells{blocks};
    SurfaceForces<Real, Dim> forces{blocks, cells};

    HostSurfaces(const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch, double cell, bool counts_energy)
        : blocks{method, patch, cell, counts_energy} {}
    HostSurfaces(const HostSurfaces&) = delete;

    /// Where a round leaves what surfaces shall count; nowhere without an energy budget.
    SurfaceMotions<Real, Dim> motions() {
        if (!blocks.counts_energy) return {};
        return {blocks.motions.data(), blocks.near_of.data()};
    }

    /// By node block, not negative: a surface is near.
    std::span<const std::int32_t> near_nodes() const { return blocks.near_of; }

    /// The step's masses are at the nodes. Collective over peers.
    void begin_step(const SurfaceScene<Real, Dim>& scene, Halo<Real, Dim>& halo, const ContactPairs<Dim>& pairs) {
        blocks.scene = scene, blocks.halo = &halo, blocks.pairs = &pairs;
        blocks.begin_step();
        forces.begin_step();
    }
};

}  // namespace moraine
