#pragma once
// What outputs say of the water in the ground (core/fluid/water_cells.hpp): of a particle, 0 of a dry one.

#include <array>
#include <string>
#include <vector>

#include "core/gravity.hpp"
#include "core/transfer/method.hpp"

namespace moraine {

template <class Real>
struct PoreFields {
    const Scene* scene;
    std::vector<PoreWater<Real>> of_body;

    explicit PoreFields(const Scene& of) : scene(&of) {
        for (const BodySpec& body : of.bodies)
            of_body.push_back(pore_water<Real>(of, of.materials[static_cast<std::size_t>(body.material)]));
    }

    /// Columns that are read.
    std::vector<std::string> needs() const { return {"body", "position", "ln_J", "pore_pressure"}; }

    template <class View>
    double porosity(const View& p, std::uint32_t s) const {
        const PoreWater<Real>& pore = of_body[p.body[s]];
        return pore.is_wet() ? static_cast<double>(pore.porosity_at(p.ln_J[s])) : 0;
    }

    /// x: its place [m]. All of the pressure, with that of still water above the soil [Pa].
    template <class View, std::size_t Dim>
    double pressure(const View& p, std::uint32_t s, const std::array<double, Dim>& x) const {
        if (!of_body[p.body[s]].is_wet()) return 0;
        const auto up = static_cast<std::size_t>(up_axis(*scene));
        return static_cast<double>(p.pore_pressure[s]) + (scene->water.submerged ? still_water(*scene, x[up]) : 0);
    }
};

}  // namespace moraine
