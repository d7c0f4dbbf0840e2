#pragma once
// Scenes of several materials, for who treats blocks of one material and blocks of several apart.

#include "sample_scenes.hpp"
#include "seeding/property_profile.hpp"

namespace moraine::test {

/// Layers of soils, each higher than a block: sand, clay on it that slides and hangs over, a film on the clay, droplets
/// of other materials, and a particle alone within the clay. Two materials, or three.
inline Scene soils(int dimensions, int materials) {
    Scene s = column();
    s.dimensions = dimensions;
    s.max = dimensions == 3 ? Triple{20, 8, 20} : Triple{24, 20, 0};
    const auto up = static_cast<std::size_t>(dimensions - 1);
    s.gravity = {0, 0, 0};
    s.gravity[up] = -9.81;
    s.periodic[1] = dimensions == 3;
    for (std::size_t a = 0; a <= up; ++a)
        s.walls[a][0].kind = s.walls[a][1].kind = s.periodic[a] ? WallKind::periodic : WallKind::free_slip;
    s.walls[up][0] = {WallKind::friction, 0.3};
    s.damping = 0;
    s.cfl = 0.65;  // at 0.5 the film's light nodes can bear all of it
    s.materials = {
        material("drucker-prager", 1800, {{"young", 2e6}, {"poisson", 0.3}, {"friction_angle", 30}, {"cohesion", 100}}),
        material("von-mises", 1500, {{"young", 1e6}, {"poisson", 0.4}, {"su", 2000}})};
    if (materials > 2) s.materials.push_back(material("neo-hookean", 1200, {{"young", 5e5}, {"poisson", 0.3}}));
    s.bodies.clear();
    const int other = materials > 2 ? 2 : 0;
    const auto put = [&](double x, double z, double length, double height, double width, int of_material) {
        Triple min = {x, 2, 0}, max = {x + length, 2 + width, 0};
        min[up] = z, max[up] = z + height;
        s.bodies.push_back(box(min, max, of_material));
        s.bodies.back().name = std::to_string(s.bodies.size());
    };
    put(0, 0, 11, 6, 6, 0);
    put(1, 6, 11, 7, 6, 1);
    put(1, 13, 9, 0.5, 6, other);
    put(14, 3, 0.5, 0.5, 0.5, 1);
    put(14, 4, 0.5, 0.5, 0.5, other);
    put(16, 1, 2, 2, 2, other);
    put(5.75, 9.75, 0.5, 0.5, 0.5, other);
    for (BodySpec& b : s.bodies) b.velocity = {b.material == 1 ? 2.0 : 0.5, 0, 0}, b.velocity[up] = -1;
    return s;
}

/// Gives a property of a material, "density" or a key of its law, a line over depth.
inline void vary(MaterialSpec& material, const std::string& property, double surface, double gradient) {
    const int at = parameter_named(*find_law(material.law), property);
    ProfileSpec profile;
    profile.surface = surface, profile.gradient = gradient;
    set_profile(material, at < 0 ? material.parameters.size() : static_cast<std::size_t>(at), profile);
}

/// soils() of two materials, of a cohesion and an undrained strength that grow with depth.
inline Scene soils_over_depth(int dimensions, double sensitivity) {
    Scene s = soils(dimensions, 2);
    s.materials[1].parameters[7] = sensitivity;
    vary(s.materials[0], "cohesion", 0, 80);
    vary(s.materials[1], "su", 300, 150);
    return s;
}

/// soils() of three materials, of which all that may vary grows with depth; the clay softens.
inline Scene soils_of_own(int dimensions) {
    Scene s = soils(dimensions, 3);
    s.materials[1].parameters[7] = 3;
    for (MaterialSpec& m : s.materials) {
        vary(m, "density", m.density, 30);
        vary(m, "young", 0.7 * m.parameters[0], 0.05 * m.parameters[0]);
    }
    vary(s.materials[0], "cohesion", 0, 80);
    vary(s.materials[0], "friction_angle", 25, 1.5);
    vary(s.materials[1], "su", 300, 150);
    return s;
}

/// layers_on_slope() of clays, on an interface that follows the soil: a strength over depth, one that softens, and one
/// that is a number.
inline Scene clays_on_slope(int dimensions) {
    Scene s = layers_on_slope(dimensions);
    const auto clay = [](const char* law, double su) {
        return material(law, 1500, {{"young", 2.5e5}, {"poisson", 0.4}, {"su", su}, {"xi95", 0.5}});
    };
    s.materials = {clay("von-mises", 900), clay("tresca", 700), clay("von-mises", 500)};
    vary(s.materials[0], "su", 300, 12000);
    vary(s.materials[0], "density", 1500, 6000);
    s.materials[1].parameters[7] = 3;
    s.materials[1].keeps_strength = true;
    choose_law_over_depth(s.materials[1]);
    BodySpec wide = s.bodies[0], second = wide, third = wide;
    wide.max[0] = 1.7, second.min[0] = 1.75, second.max[0] = 2.4, third.min[0] = 2.45;
    second.material = 1, third.material = 2;
    s.bodies = {wide, second, third, s.bodies[1]};
    for (BodySpec& body : s.bodies) body.min[1] -= 0.14, body.max[1] -= 0.14;
    s.structures[0].soil_su = true, s.structures[0].su = 900;
    return s;
}

/// spray() of three materials, at a step that is too large for its light nodes.
inline Scene three_sprays(int dimensions) {
    Scene s = spray(dimensions);
    s.cfl = 0.65;
    s.materials.push_back(material("neo-hookean", 1200, {{"young", 5e5}, {"poisson", 0.3}}));
    s.bodies[3].material = 2;
    return s;
}

/// Two boxes of a clay that no block has both of. apart: each is of a material of its own, with the same numbers.
inline Scene twins(int dimensions, bool apart) {
    Scene s = soils(dimensions, 2);
    s.max[0] = 36;
    s.limits_light_nodes = false;
    s.materials.erase(s.materials.begin());
    if (apart) s.materials.push_back(s.materials.front());
    const auto up = static_cast<std::size_t>(dimensions - 1);
    Triple min = {2, 1, 0}, max = {9, 6, 0};
    min[up] = 0, max[up] = 5;
    s.bodies = {box(min, max, 0)};
    min[0] += 20, max[0] += 20;
    s.bodies.push_back(box(min, max, apart ? 1 : 0));
    for (BodySpec& b : s.bodies) b.wave.velocity[up] = 1, b.wave.wavelength = 8;
    s.bodies[0].velocity = {1, 0, 0}, s.bodies[1].velocity = {-1, 0, 0};
    return s;
}

}  // namespace moraine::test
