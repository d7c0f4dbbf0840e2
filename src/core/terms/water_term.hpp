#pragma once
// Water in the pores (fluid/water_cells.hpp) as a term: a particle takes its pore pressure and its change of volume
// from its cell, and Darcy's flux from the nodes.
//
//   w_p <- w + phi (w_p + dw - w),  phi = 1 / (1 + dt R n0 / rho_w)      w, dw: of the nodes
//
// What a particle's flux has beside the grid's is moved by no pressure, but drag takes it as it takes any. Nor does the
// grid see how pressures differ inside a cell, and in what flows they come apart: as in grid_pressure.hpp particles go
// to the cell's mean and the slope of still water about it, by a share a = min(1/2, 0.22 c dt / h) a step.
//
// Water cavitates: p >= -cavitation (below the air's pressure). What opens beyond is gas at that pressure, of no volume
// when the pores close again; opening and closing takes energy and gives none.

#include "core/fluid/pressure_smoothing.hpp"
#include "core/fluid/water_cells.hpp"
#include "core/grid/stencil.hpp"
#include "core/nodes/water_nodes.hpp"
#include "core/particles/stress.hpp"
#include "core/terms/gather_point.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

template <class Real, int Dim>
struct WaterTerm {
    static constexpr unsigned hooks = hook_block | hook_stress;
    const PoreWater<Real>* pores;      ///< by body; null: the scene has none
    const CellPressure<Real>* cell;    ///< [tile][cell]
    const WaterCell<Real>* water;      ///< likewise
    const WaterNode<Real, Dim>* node;  ///< [node block][node]
    Vec<Real, Dim> gravity;            ///< [m/s2]
    Real cavitation;                   ///< tension that water bears; under still water at base + f = 0 [Pa]
    Vec<Real, Dim> still;              ///< rho_w g h of still water that pressures are in excess of [Pa]

    template <class Case>
    struct State {
        Vec<Real, Dim> flux[Case::tile_nodes], start[Case::tile_nodes];
    };

    MORAINE_HD bool on(const auto&) const { return pores != nullptr; }

    template <class Case>
    MORAINE_HD void at_block(const auto& of, int block, const Quad<Real>*, State<Case>& state) const {
        for (int n = 0; n < Case::tile_nodes; ++n) {
            const WaterNode<Real, Dim>& w = node[of.stored_node(block, n)];
            state.flux[n] = w.flux, state.start[n] = w.start;
        }
    }

    template <class Case>
    MORAINE_HD void before_stress(const auto& of, const CellInWork<Case>& in, const auto& point, auto& dL,
                                  State<Case>& state, auto& out) const {
        const std::uint32_t s = point.slot;
        const PoreWater<Real>& pore = pores[of.p.body[s]];
        if (!pore.is_wet()) return;
        const Real n = pore.porosity_at(point.ln_J()), storage = pore.storage(n);
        const Real drag = of.round.dt * pore.resistance / pore.inertia(pore.porosity);
        weigh(of, pore, point, out);
        take_flux<Case>(of, in, point, state, Real(1) / (Real(1) + drag));

        smooth(of, in, point, pore.wave_speed(n, of.p.mass[s] / point.volume()));
        const CellStep<Real> step = CellStep<Real>::of(of.cell_of(cell, in));
        const Real all = taken_increment(step.increment, step.in_tension, borne_share(step.loose, storage));
        Real& p = of.p.pore_pressure[s];
        const Real before = p;
        p -= storage * all;
        const Real least = -cavitation - gravity_pressure(still, in.base, point.stencil_of().f);
        if (p < least) p = least;
        out.work -= double(point.volume()) * double(Real(0.5) * (before + p)) * double(all);
        Real cubic;
        dL = increment_of_trace(dL, of.cell_of(water, in).increment, cubic);
        point.ln_J() -= cubic;
        tell(of, pore, point, n, out);
    }

  private:
    /// load_force had the weight of water that came or went; of tractions is what else it had.
    MORAINE_HD void weigh(const auto& of, const PoreWater<Real>& pore, const auto& point, auto& out) const {
        const Real more = of.round.dt * pore.more_mass(of.p.mass[point.slot], point.volume());
        for (int a = 0; a < Dim; ++a) {
            const double impulse = double(more) * double(gravity[a]), work = impulse * double(point.sums.velocity()[a]);
            out.weight_impulse[a] += impulse, out.weight_work += work;
            out.load_impulse[a] -= impulse, out.load_work -= work;
        }
    }

    template <class Case>
    MORAINE_HD void take_flux(const auto& of, const CellInWork<Case>& in, const auto& point, const State<Case>& state,
                              Real keeps) const {
        auto n = point.stencil_of();
        for (int a = 0; a < Dim; ++a) fold_weights<Case::width>(in.ghosts[a], n.w[a], n.dw[a]);
        Vec<Real, Dim> now = zero_vec<Real, Dim>(), before = zero_vec<Real, Dim>();
        const int corner = tile_offset<Dim, Case::width>(in.number);
        each_node<Dim, Case::width>([&](int at, int i, int j, int k) {
            const int place[3] = {i, j, k};
            Real w = Real(1);
            for (int a = 0; a < Dim; ++a) w *= n.w[a][place[a]];
            for (int a = 0; a < Dim; ++a) {
                now[a] += w * state.flux[corner + at][a];
                before[a] += w * state.start[corner + at][a];
            }
        });
        Vec<Real, Dim>& own = of.p.darcy_velocity[point.slot];
        for (int a = 0; a < Dim; ++a) own[a] = now[a] + keeps * (own[a] - before[a]);
    }

    template <class Case>
    MORAINE_HD void smooth(const auto& of, const CellInWork<Case>& in, const auto& point, Real wave) const {
        const Real share = Real(0.22) * wave * of.round.dt * of.context.inverse_cell;
        const auto n = point.stencil_of();
        const Real mean = of.cell_of(cell, in).head - gravity_pressure(of.context.gravity_slope, in.base, n.f);
        Real& p = of.p.pore_pressure[point.slot];
        p += (share < Real(0.5) ? share : Real(0.5)) * (-mean - p);
    }

    MORAINE_HD void tell(const auto& of, const PoreWater<Real>& pore, const auto& point, Real n, auto& out) const {
        using std::sqrt;
        const Real wave = pore.wave_speed(n, of.p.mass[point.slot] / point.volume());
        const double signal = double(wave + sqrt(square_speed<Real, Dim>(point)));
        if (signal > out.signal) out.signal = signal;
        if (n <= Real(PoreWater<Real>::least_porosity) || n >= Real(PoreWater<Real>::most_porosity))
            out.fault(fault_porosity, of.p.id[point.slot]);
    }
};

}  // namespace moraine
