#include "predict/lattice_prediction.hpp"

#include <algorithm>

#include "predict/prediction.hpp"
#include "seeding/lattice_seeds.hpp"
#include "seeding/seed.hpp"

namespace moraine {

namespace {

template <class Real, int Dim>
LatticePrediction predict_in(const Scene& scene) {
    const Method<Host, Real, Dim> method(scene);
    const LatticeTables<Real, Dim> tables = lattice_tables(scene, method, DomainBlocks<Dim>(scene));
    LatticePrediction p;
    for (const LatticeBlock& block : lattice_blocks(tables, false)) {
        p.occupied.push_back(block.key);
        p.particles += block.particles;
    }
    return p;
}

/// Speed differs along the axis of the wave alone.
double top_speed(const BodySpec& body, const Lattice& lattice) {
    const auto axis = static_cast<std::size_t>(body.wave.axis);
    double speed = 0;
    for (std::int64_t i = 0; i < lattice.count[axis]; ++i) {
        Triple x{};
        x[axis] = lattice.place(axis, i);
        speed = std::max(speed, norm(start_velocity(body, x)));
    }
    return speed;
}

}  // namespace

LatticePrediction predict_lattice(const Scene& scene) {
    const bool single = scene.precision == Precision::single_;
    LatticePrediction p;
    if (scene.dimensions == 2)
        p = single ? predict_in<float, 2>(scene) : predict_in<double, 2>(scene);
    else
        p = single ? predict_in<float, 3>(scene) : predict_in<double, 3>(scene);
    for (const BodySpec& body : scene.bodies) {
        p.speed.push_back(top_speed(body, lattice_of(scene, body)));
        p.mass += scene.materials[static_cast<std::size_t>(body.material)].density * measure_of(body, scene.dimensions);
    }
    return p;
}

std::optional<Triple> first_inside(const Scene& scene, const BodySpec& body, const BodySpec& box) {
    const Lattice lattice = lattice_of(scene, body);
    Triple found{};
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        std::int64_t i = 0;
        while (i < lattice.count[a] && !(lattice.place(a, i) > box.min[a] && lattice.place(a, i) < box.max[a])) ++i;
        if (i == lattice.count[a]) return {};
        found[a] = lattice.place(a, i);
    }
    return found;
}

}  // namespace moraine
