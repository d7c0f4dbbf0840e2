#pragma once
// How much of pore pressure alternates from cell to cell.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "simulation/diagnostics.hpp"

namespace moraine::verification {

/// Second differences of the pore pressures of cells along all axes over 4 times what the soil bears there, pore
/// pressure and effective stress, as root mean squares: 1 of a checkerboard of the pore pressure, 0.6 of noise, h^2 /
/// (4 L^2) of what varies over L. Of rows of three cells that are full of saturated soil; 0 where fewer than 9 are. On
/// one rank.
template <class Real, int Dim>
double checkerboard(Simulation<Real, Dim>& sim) {
    const Scene& scene = sim.scene();
    const ParticleView<Real, Dim> p = sim.patch().particles.view();
    std::map<std::array<long, Dim>, std::array<double, 3>> cells;  // volume, and times pressure and mean stress
    each_particle(sim, [&](std::uint32_t s, const std::array<double, Dim>& x) {
        if (!sim.method().pores()[p.body[s]].is_wet()) return;
        std::array<long, Dim> cell;
        for (std::size_t a = 0; a < Dim; ++a) cell[a] = std::lround((x[a] - scene.min[a]) / scene.cell);
        const double volume = double(p.volume[s]);
        cells[cell][0] += volume, cells[cell][1] += volume * double(p.pore_pressure[s]);
        cells[cell][2] += volume / 3 * double(p.stress[s].trace());
    });
    const double full = std::pow(scene.cell, Dim);
    double apart = 0, all = 0;
    int rows = 0;
    for (const auto& [cell, own] : cells)
        for (std::size_t a = 0; a < Dim; ++a) {
            auto before = cell, after = cell;
            before[a] -= 1, after[a] += 1;
            const auto low = cells.find(before), high = cells.find(after);
            if (low == cells.end() || high == cells.end()) continue;
            double second = 0, borne = 0, least = own[0];
            for (const auto& [c, weight] : {std::pair{low->second, 1.0}, {own, -2.0}, {high->second, 1.0}}) {
                second += weight * c[1] / c[0];
                borne += (c[1] * c[1] + c[2] * c[2]) / (c[0] * c[0]) / 3;
                least = std::min(least, c[0]);
            }
            if (least < 0.8 * full) continue;
            apart += std::pow(0.25 * second, 2), all += borne;
            ++rows;
        }
    return rows < 9 || !(all > 0) ? 0 : std::sqrt(apart / all);
}

}  // namespace moraine::verification
