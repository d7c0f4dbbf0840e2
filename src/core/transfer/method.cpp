#include "core/transfer/method.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/particles/make_traction.hpp"

namespace moraine {
namespace {

/// FMPM(k): particles take S v_l in all rounds but the last, and in that the sum of the series (nodes.hpp).
std::vector<Round> series_rounds(int order) {
    std::vector<Round> rounds(static_cast<std::size_t>(order), {NodeTask::extend, gather_velocity});
    rounds.front().nodes = NodeTask::begin;
    rounds.back() = {order > 1 ? NodeTask::conclude : NodeTask::begin,
                     gather_velocity | gather_motion | gather_gradient};
    return rounds;
}

/// By eigenvalues and runs of single layers, droplets and sprays (docs/adr/0006).
template <class Real>
ReactionLimits<Real> reaction_limits(const Scene& scene) {
    if (scene.stress_update == StressUpdate::musl) return {Real(1.2), Real(3), Real(3), true};
    const bool affine = is_affine(scene.transfer);
    return {Real(1.6), Real(affine ? 2.5 : 1.6), Real(affine ? 2 : 1.6), false};
}

/// K [Pa], of an isotropic law.
double bulk_modulus(const MaterialSpec& material) {
    const double poisson = poisson_ratio(material);
    return find_law(material.law)->wave_modulus(material.parameters.data()) * (1 + poisson) / (3 * (1 - poisson));
}

bool has_shifts(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const MaterialSpec& m) { return m.particle_shifting > 0; });
}

/// In scenes with shifts the steps between them smooth for those that shift.
template <class Real>
FluidTerms<Real> fluid_terms_of(const Scene& scene, const MaterialSpec& material) {
    const bool every = uses_grid_pressure(scene);  // step, both
    const double between = every ? 1 : has_shifts(scene) ? shift_interval - 1 : shift_interval;
    const double interval = every ? 1 : shift_interval, speed = wave_speed(material);
    return {static_cast<Real>(material.pressure_smoothing * speed / scene.cell * interval / between),
            static_cast<Real>(1 / bulk_modulus(material)),
            static_cast<Real>(interval * material.particle_shifting * speed * scene.cell)};
}

/// rho g h along an axis, of the water in the ground or the first material that smooths its pressure [Pa]; along
/// periodic axes, and where pressures are in excess of still water, 0.
double gravity_slope(const Scene& scene, std::size_t axis) {
    if (scene.water.on)
        return scene.periodic[axis] || scene.water.submerged ? 0
                                                             : scene.water.density * scene.gravity[axis] * scene.cell;
    for (const MaterialSpec& m : scene.materials)
        if (m.pressure_smoothing > 0 && !scene.periodic[axis]) return m.density * scene.gravity[axis] * scene.cell;
    return 0;
}

template <class Real, int Dim>
Stiffness<Real> stiffness_of(const MaterialSpec& material, double cell) {
    const LawInfo& law = *find_law(material.law);
    const double poisson = poisson_ratio(material);
    const double wave = law.wave_modulus(material.parameters.data());
    const double twice_shear = (1 - 2 * poisson) / (1 - poisson);  // over lambda + 2 G
    if (material.volumetric == Volumetric::grid)                   // the cells bear K: 4G/3 is left
        return {static_cast<Real>(wave * twice_shear * 2 / 3), static_cast<Real>(1.5 / Dim - 0.5),
                static_cast<Real>(material.density * std::pow(cell, Dim))};
    return {static_cast<Real>(wave), static_cast<Real>(1 - twice_shear + twice_shear / Dim),
            static_cast<Real>(material.density * std::pow(cell, Dim))};
}

}  // namespace

template <class Real>
PoreWater<Real> pore_water(const Scene& scene, const MaterialSpec& material) {
    if (!(material.porosity > 0)) return {};
    return {static_cast<Real>(material.porosity),
            static_cast<Real>(scene.water.density * conductivity_gravity / material.conductivity),
            static_cast<Real>(find_law(material.law)->wave_modulus(material.parameters.data())),
            static_cast<Real>(bulk_modulus(material)),
            static_cast<Real>(scene.water.density),
            static_cast<Real>(scene.water.bulk),
            static_cast<Real>(1 / material.density),
            scene.water.submerged};
}
template PoreWater<float> pore_water(const Scene&, const MaterialSpec&);
template PoreWater<double> pore_water(const Scene&, const MaterialSpec&);

std::vector<Round> rounds_of(const Scene& scene) {
    if (uses_grid_pressure(scene)) return {{NodeTask::hold, gather_velocity | gather_motion | gather_gradient}};
    if (scene.transfer == Transfer::fmpm) return series_rounds(scene.order);
    switch (scene.stress_update) {
        case StressUpdate::usf:
            return {{NodeTask::velocity, gather_gradient}, {NodeTask::solve, gather_velocity | gather_motion}};
        case StressUpdate::musl:
            return {{NodeTask::solve, gather_velocity}, {NodeTask::again, gather_gradient | gather_second_motion}};
        default:
            return {{NodeTask::solve, gather_velocity | gather_motion | gather_gradient}};
    }
}

bool limits_accelerations(const Scene& scene) {
    return scene.limits_light_nodes && scene.shape != moraine::Shape::linear && scene.transfer != Transfer::fmpm &&
           scene.stress_update != StressUpdate::usf;
}

double poisson_ratio(const MaterialSpec& material) {
    const LawInfo& law = *find_law(material.law);
    for (std::size_t k = 0; k < law.parameters.size(); ++k)
        if (law.parameters[k].key == std::string_view("poisson")) return material.parameters[k];
    return 0.5;
}

double wave_speed(const MaterialSpec& material) {
    return std::sqrt(find_law(material.law)->wave_modulus(material.parameters.data()) / material.density);
}

double shear_wave_share(const Scene& scene) {
    double most = 0;
    for (const MaterialSpec& m : scene.materials) {
        const double poisson = poisson_ratio(m);
        most = std::max(most, std::sqrt((1 - 2 * poisson) / (2 - 2 * poisson)));
    }
    return most;
}

bool has_fluid_terms(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const MaterialSpec& m) { return has_fluid_terms(m); });
}

ColumnNeeds needs_of(const Scene& scene) {
    ColumnNeeds needs;
    needs.affine = is_affine(scene.transfer);
    needs.log_stretch = scene.shape == moraine::Shape::gimp_contiguous;
    needs.sleep = scene.sleep.on;
    needs.loads = !scene.course.tractions.empty();
    needs.water = scene.water.on;
    for (const MaterialSpec& m : scene.materials) {
        const LawInfo& law = *find_law(m.law);
        needs.left_stretch = needs.left_stretch || law.uses_left_stretch;
        needs.history = std::max(needs.history, law.history);
    }
    return needs;
}

template <class Space, class Real, int Dim>
Method<Space, Real, Dim>::Method(const Scene& scene) : stencil(stencil_of(scene.shape)), needs(needs_of(scene)) {
    cell = static_cast<Real>(scene.cell);
    context.walls = make_walls<Real, Dim>(scene);
    capacity = node_capacity<Real, Dim>(scene, context.walls);
    context.inverse_cell = static_cast<Real>(1 / scene.cell);
    kernels = choose_kernels<Real, Dim>(scene.shape, needs.affine);
    rounds = rounds_of(scene);
    const bool blends = scene.transfer == Transfer::flip || scene.transfer == Transfer::aflip;
    flip = blends ? static_cast<Real>(scene.flip) : Real(0);
    tpic = scene.transfer == Transfer::tpic;
    damping = static_cast<Real>(scene.damping);
    for (int a = 0; a < Dim; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        context.gravity_slope[a] = static_cast<Real>(gravity_slope(scene, axis));
        for (int s = 0; s < 2; ++s) {
            const int far = std::int32_t(1) << 29;
            ends.cell[a][s] = scene.periodic[axis] ? (s == 0 ? -far : far) : context.walls.plane[a][s];
            ends.fraction[a][s] = static_cast<Real>(stencil.offset());
            ends.still[a][s] = context.walls.fold[a][s] && limits_accelerations(scene);
            absorbs[a][s] = scene.walls[axis][static_cast<std::size_t>(s)].absorbs;
            ends.open[a][s] = scene.walls[axis][static_cast<std::size_t>(s)].kind == WallKind::open;
        }
    }
    for (const MaterialSpec& m : scene.materials) {
        laws_.push_back(make_law_batch<Real, Dim>(m));
        law_pointers_.push_back(laws_.back().get());
    }
    for (const BodySpec& b : scene.bodies) {
        material_of_.push_back(static_cast<std::uint16_t>(b.material));
        Vec<Real, Dim> half;
        for (int a = 0; a < Dim; ++a)
            half[a] = static_cast<Real>(0.5 / b.particles_per_cell[static_cast<std::size_t>(a)]);
        half_size_.push_back(half);
    }
    context.half_size = half_size_.data();
    limits = reaction_limits<Real>(scene);
    shifts_ = has_shifts(scene);
    for (const TractionSpec& t : scene.course.tractions) tractions_.push_back(make_traction<Real, Dim>(scene, t));
    list_terms(scene);
}

/// What bodies have of their materials, where any body has it.
template <class Space, class Real, int Dim>
void Method<Space, Real, Dim>::list_terms(const Scene& scene) {
    const auto has = [&](Volumetric wanted) {
        return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& b) {
            return scene.materials[static_cast<std::size_t>(b.material)].volumetric == wanted;
        });
    };
    for (const BodySpec& b : scene.bodies) {
        const MaterialSpec& m = scene.materials[static_cast<std::size_t>(b.material)];
        if (limits_accelerations(scene)) stiffness_.push_back(stiffness_of<Real, Dim>(m, scene.cell));
        if (has_fluid_terms(scene)) fluid_.push_back(fluid_terms_of<Real>(scene, m));
        const bool of_grid = m.volumetric == Volumetric::grid;
        if (has(Volumetric::grid)) grid_bulk_.push_back(of_grid ? static_cast<Real>(bulk_modulus(m)) : Real(0));
        if (scene.water.on) pores_.push_back(pore_water<Real>(scene, m));
        if (has(Volumetric::cell)) averaged_.push_back(m.volumetric == Volumetric::cell);
    }
}

template struct Method<Host, float, 2>;
template struct Method<Host, float, 3>;
template struct Method<Host, double, 2>;
template struct Method<Host, double, 3>;

}  // namespace moraine
