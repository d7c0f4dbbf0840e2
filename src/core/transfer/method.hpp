#pragma once
// The method of one scene: everything about it that does not change during a run, in kernel form.

#include <memory>
#include <string_view>
#include <vector>

#include "core/courant.hpp"
#include "core/data/host.hpp"
#include "core/fluid/particle_shifting.hpp"
#include "core/grid/light_nodes.hpp"
#include "core/material/laws.hpp"
#include "core/material/pore_water.hpp"
#include "core/nodes/nodes.hpp"
#include "core/particles/place_step.hpp"
#include "core/particles/traction.hpp"
#include "core/scene_spec.hpp"
#include "core/transfer/kernel_list.hpp"
#include "core/transfer/scene_walls.hpp"

namespace moraine {

/// One round of a scheme: sums to the nodes, halo, nodes, gather. What particles are newly to do in a step, say a shift
/// towards an even spacing, is one round more in the list of its scheme: a NodeTask says what the nodes make of their
/// sums (nodes.hpp), a bit of Gather what particles take of it (particle_update.hpp). Halo and order know nothing of
/// it.
struct Round {
    NodeTask nodes;
    unsigned gather;
};

/// USL: Sulsky et al. 1994 with the stress last (the method paper's). USF, MUSL: Bardenhagen 2002.
std::vector<Round> rounds_of(const Scene& scene);

/// Whether light nodes are limited (light_nodes.hpp): where the scene wants it, with wide shapes where the stress
/// follows the forces.
bool limits_accelerations(const Scene& scene);

/// 1/2 where the law has none.
double poisson_ratio(const MaterialSpec& material);

/// sqrt((K + 4G/3) / rho) [m/s].
double wave_speed(const MaterialSpec& material);

/// Of soil and its pores, with the scene's water; of a dry material all zero.
template <class Real>
PoreWater<Real> pore_water(const Scene& scene, const MaterialSpec& material);

/// c_s / c, the largest of all materials.
double shear_wave_share(const Scene& scene);

bool has_fluid_terms(const Scene& scene);

template <class Space, class Real, int Dim>
struct Method {
    explicit Method(const Scene& scene);

    Stencil stencil;
    StencilContext<Real, Dim> context;
    DomainEnds<Real, Dim> ends;
    TransferKernels<Real, Dim> kernels;
    std::vector<Round> rounds;
    ColumnNeeds needs;
    Real cell;  ///< h [m]
    Real flip;  ///< share of FLIP [-]
    bool tpic;
    Real damping;  ///< [-]
    ReactionLimits<Real> limits;

    HostStress<Real, Dim> stress() const {
        return {law_pointers_.data(), static_cast<int>(laws_.size()), material_of_.data()};
    }
    /// By body: whether its volumetric part is that of its cell (volumetric.hpp); null where none does.
    const std::uint8_t* averaged() const { return averaged_.empty() ? nullptr : averaged_.data(); }
    /// By body, for light nodes; null where the method does not limit what they do (light_nodes.hpp).
    const Stiffness<Real>* stiffness() const { return stiffness_.empty() ? nullptr : stiffness_.data(); }
    /// By body, of fluids; null where none has any (pressure_smoothing.hpp, particle_shifting.hpp).
    const FluidTerms<Real>* fluid() const { return fluid_.empty() ? nullptr : fluid_.data(); }
    /// What nodes sum besides in the step with this number.
    NodeMean mean_of(std::int64_t step) const {
        if (grid_bulk()) return NodeMean::volume;
        if (fluid_.empty()) return NodeMean::none;
        return shifts_ && shifts_in(step) ? NodeMean::volume : NodeMean::stress;
    }
    /// By body: K where the pressure is the grid's, else 0 [Pa]; null: nowhere (grid_pressure.hpp).
    const Real* grid_bulk() const { return grid_bulk_.empty() ? nullptr : grid_bulk_.data(); }
    /// By body: the water in its pores (fluid/water_cells.hpp); null: none has any.
    const PoreWater<Real>* pores() const { return pores_.empty() ? nullptr : pores_.data(); }
    const std::vector<Traction<Real, Dim>>& tractions() const { return tractions_; }
    bool shifts() const { return shifts_; }  ///< some body's particles
    const LawBatch<Real, Dim>& law_of(int body) const { return *laws_[material_of_[static_cast<std::size_t>(body)]]; }

    NodeCapacity<Real, Dim> capacity;
    bool absorbs[Dim][2];  ///< faces (core/nodes/absorbing_ends.hpp)

  private:
    void list_terms(const Scene& scene);

    std::vector<std::unique_ptr<LawBatch<Real, Dim>>> laws_;
    std::vector<const LawBatch<Real, Dim>*> law_pointers_;
    std::vector<std::uint16_t> material_of_;  ///< by body
    std::vector<std::uint8_t> averaged_;      ///< by body; empty: none
    std::vector<Vec<Real, Dim>> half_size_;   ///< by body [cells]
    std::vector<Stiffness<Real>> stiffness_;  ///< by body; empty: not wanted
    std::vector<FluidTerms<Real>> fluid_;     ///< by body; empty: none
    std::vector<Real> grid_bulk_;             ///< by body; empty: none
    std::vector<PoreWater<Real>> pores_;      ///< by body; empty: none
    std::vector<Traction<Real, Dim>> tractions_;
    bool shifts_ = false;  ///< some body's particles are shifted
};

ColumnNeeds needs_of(const Scene& scene);

}  // namespace moraine
