#pragma once
// The state of a seed (seeding/seed.hpp) as a particle: in a slot of a share, and the block it is binned in.

#include "blocks/topology.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/traction_place.hpp"

namespace moraine {

/// The block of a seed.
template <class Real, int Dim>
Key key_of_seed(const Scene& scene, const Method<Host, Real, Dim>& method, const DomainBlocks<Dim>& domain,
                const Seed& seed) {
    BlockPosition<Dim> block{};
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        block[i] = place_along(scene, method, a, seed.x[i]).block;
    }
    domain.wrap(block);
    return Morton<Dim>::encode(block);
}

/// What the law keeps of its own (core/material/over_depth.hpp).
template <class Real, int Dim>
void place_own(const Scene& scene, const BodySpec& body, const ParticleView<Real, Dim>& p, const Seed& seed,
               std::uint32_t slot) {
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
    for (const ProfileSpec& profile : m.profiles)
        p.history[profile.scalar][slot] = static_cast<Real>(profile_at(scene, body, profile, seed.x));
    if (!m.keeps_strength) return;
    const LawInfo& law = *find_law(m.law);
    const auto su = static_cast<std::size_t>(parameter_named(law, "su"));
    const ProfileSpec* profile = m.profile_of(su);
    p.history[scalar_named(law, "strength")][slot] =
        static_cast<Real>(profile ? profile_at(scene, body, *profile, seed.x) : m.parameters[su]);
}

/// The state of one seed, in its slot.
template <class Real, int Dim>
Key place_seed(const Scene& scene, const Method<Host, Real, Dim>& method, const DomainBlocks<Dim>& domain,
               const ParticleView<Real, Dim>& p, const Seed& seed, std::uint32_t slot) {
    const BodySpec& body = scene.bodies[static_cast<std::size_t>(seed.body)];
    BlockPosition<Dim> block{};
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const Place<Real> at = place_along(scene, method, a, seed.x[i]);
        block[i] = at.block;
        p.position[slot][a] = at.u;
        p.velocity[slot][a] = static_cast<Real>(seed.velocity[i]);
    }
    domain.wrap(block);
    p.id[slot] = seed.id;
    p.body[slot] = static_cast<std::uint16_t>(seed.body);
    p.mass[slot] = static_cast<Real>(seed.mass);
    p.volume[slot] = static_cast<Real>(seed.mass / density_at(scene, body, seed.x));
    p.stress[slot] = zero_sym<Real, Dim>();
    const Vec<Real, 3> stress = geostatic_stress<Real>(scene, body, seed.x);
    for (int k = 0; k < 3; ++k) p.stress[slot][k] = stress[k];
    clear_rest(p, slot);
    method.law_of(seed.body).begin(body.start, p, slot);
    place_own(scene, body, p, seed, slot);
    if (p.pore_pressure) p.pore_pressure[slot] = static_cast<Real>(start_pore_pressure(scene, body, seed.x));
    for (std::size_t k = 0; k < scene.course.tractions.size(); ++k)
        p.load_place[slot][static_cast<int>(k)] =
            static_cast<Real>(load_place(scene, scene.course.tractions[k], seed.body, seed.x));
    return Morton<Dim>::encode(block);
}

}  // namespace moraine
