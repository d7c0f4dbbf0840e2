#pragma once
// S24: random scenes of fluids whose pressure is the grid's (core/fluid/grid_pressure.hpp), number n: blocks that fall
// apart, films, sprays, corners, drops that fall into pools, tanks. Every transfer that takes it, nu from 0.45 to
// 0.4999, 1 to 10 substeps, with and without smoothing and shifts, the whole default step. As in S23 (thin_scene.hpp)
// all is drawn from n, h and rho are 1, c is 1, speeds at most Mach 0.25.

#include "core/fluid/grid_pressure.hpp"
#include "verification/thin_scene.hpp"

namespace moraine::verification {

enum class FluidKind { block, film, spray, corner, splash, tank };

/// A scene's number decides its kind in turn.
inline FluidKind fluid_kind(std::uint64_t number) {
    return static_cast<FluidKind>(number % 6);
}

inline const char* name_of(FluidKind kind) {
    constexpr const char* names[] = {"block", "film", "spray", "corner", "splash", "tank"};
    return names[static_cast<int>(kind)];
}

namespace detail {

inline void draw_fluid_method(Draw& draw, Scene& scene) {
    constexpr Transfer transfers[] = {Transfer::flip, Transfer::pic, Transfer::apic, Transfer::tpic, Transfer::aflip};
    scene.transfer = transfers[draw.below(5)];
    scene.flip = standard_flip(scene.transfer);
    scene.stress_update = StressUpdate::usl;
    scene.substeps = 1 + draw.below(most_substeps);
}

inline MaterialSpec draw_fluid(Draw& draw) {
    constexpr const char* laws[] = {"newtonian", "bingham", "herschel-bulkley"};
    const double nu = 0.5 - draw.log_between(1e-4, 5e-2), strength = draw.log_between(1e-6, 1e-3);
    const double viscosity = draw.with(0.3) ? 0 : draw.log_between(1e-4, 1e-1);
    MaterialSpec m = material(laws[draw.below(3)], 1,
                              {{"young", young_for(1, nu)},
                               {"poisson", nu},
                               {"viscosity", viscosity},
                               {"yield_stress", strength},
                               {"consistency", draw.log_between(1e-4, 1e-1)},
                               {"exponent", draw.between(0.3, 1)}});
    m.volumetric = Volumetric::grid;
    if (draw.with(0.7)) m.pressure_smoothing = draw.with(0.5) ? 0.22 : draw.between(0.05, 0.5);
    if (draw.with(0.7)) m.particle_shifting = draw.with(0.5) ? 0.2 : draw.between(0.05, 0.5);
    return m;
}

/// Particles per cell and axis, in place or jittered.
inline void draw_filling(Draw& draw, const Scene& scene, BodySpec& body) {
    const int per_cell = scene.dimensions == 2 ? 1 + draw.below(4) : 1 + draw.below(3);
    for (int& count : body.particles_per_cell) count = per_cell;
    if (draw.with(0.3)) body.seeding = Seeding::jittered, body.jitter = draw.between(0, 0.5);
}

inline BodySpec fluid_box(Draw& draw, const Scene& scene, Triple min, Triple max) {
    BodySpec body;
    body.min = min, body.max = max;
    draw_filling(draw, scene, body);
    return body;
}

/// A fixed plane or sphere in a lower corner.
inline void draw_obstacle(Draw& draw, Scene& scene) {
    StructureSpec s = draw_surface(draw);
    if (draw.with(0.5)) {
        s.shape = StructureShape::sphere;
        s.radius = draw.between(1.2, 2.5);
        s.center = {draw.between(0, scene.max[0]), draw.between(0, 1), 0.5 * scene.max[2]};
    } else {
        s.normal = {draw.between(-0.7, 0.7), 1, 0};
        s.point = {0.5 * scene.max[0], draw.between(0, 1.5), 0};
    }
    scene.structures.push_back(s);
}

/// A block, up to 6 cells high, that stands at a wall or alone.
inline void draw_column(Draw& draw, Scene& scene) {
    const double from = draw.with(0.5) ? 0 : draw.between(0, 4), bottom = draw.with(0.7) ? 0 : draw_height(draw);
    BodySpec body = fluid_box(draw, scene, {from, bottom, 0},
                              {from + draw.between(1, 6), bottom + draw.between(0.5, 6), scene.max[2]});
    if (draw.with(0.3)) body.max[2] *= draw.between(0.4, 1);
    if (draw.with(0.5)) body.velocity[0] = draw.between(-0.1, 0.1);
    body.geostatic = draw.with(0.5), body.geostatic_surface = body.max[1];
    scene.bodies.push_back(body);
    draw_gravity(draw, scene, draw.log_between(1e-5, 2e-3));
}

inline void draw_thin_layer(Draw& draw, Scene& scene) {
    const double bottom = draw_height(draw);
    BodySpec body = fluid_box(draw, scene, {draw.between(0, 3), bottom, 0},
                              {draw.between(6, 12), bottom + draw.log_between(0.3, 3), scene.max[2]});
    if (draw.with(0.5)) body.velocity[0] = draw.between(0, 0.1);
    scene.bodies.push_back(body);
    draw_gravity(draw, scene, draw.log_between(1e-6, 1e-3));
}

/// Boxes that fly into a lower corner.
inline void draw_corner(Draw& draw, Scene& scene) {
    const double from = draw_height(draw), bottom = draw_height(draw), size = draw.log_between(0.3, 4);
    BodySpec body =
        fluid_box(draw, scene, {from, bottom, 0}, {from + size, bottom + size * draw.between(0.5, 1), scene.max[2]});
    if (scene.dimensions == 3) body.min[2] = draw.between(0, 1), body.max[2] = body.min[2] + std::min(size, 2.5);
    body.velocity = {-draw.between(0, 0.15), -draw.between(0, 0.15), 0};
    scene.bodies.push_back(body);
    draw_gravity(draw, scene, draw.log_between(1e-6, 2e-3));
}

/// A pool across the domain.
inline void draw_pool(Draw& draw, Scene& scene, double depth) {
    BodySpec pool = fluid_box(draw, scene, {0, 0, 0}, {scene.max[0], depth, scene.max[2]});
    pool.geostatic = draw.with(0.7), pool.geostatic_surface = depth;
    scene.bodies.push_back(pool);
}

/// A drop above a pool.
inline void draw_splash(Draw& draw, Scene& scene) {
    const double depth = draw.between(0.5, 3);
    draw_gravity(draw, scene, draw.log_between(1e-5, 2e-3));
    draw_pool(draw, scene, depth);
    BodySpec drop = draw_droplet(draw, scene, 0.05);
    drop.center[1] = depth + drop.radius + draw_height(draw);
    drop.velocity[1] = -draw.between(0.02, 0.2);
    scene.bodies.push_back(drop);
}

inline void draw_fluid_bodies(Draw& draw, Scene& scene, FluidKind kind) {
    switch (kind) {
        case FluidKind::block:
            return draw_column(draw, scene);
        case FluidKind::film:
            return draw_thin_layer(draw, scene);
        case FluidKind::spray:
            return draw_spray(draw, scene);
        case FluidKind::corner:
            return draw_corner(draw, scene);
        case FluidKind::splash:
            return draw_splash(draw, scene);
        case FluidKind::tank:
            draw_gravity(draw, scene, draw.log_between(1e-5, 2e-3));
            return draw_pool(draw, scene, draw.between(0.5, 5));
    }
}

}  // namespace detail

inline Scene fluid_scene(std::uint64_t number) {
    Draw draw(number + (std::uint64_t(1) << 33));  // not those of S22 and S23
    Scene scene = begin_scene("fluid", number, draw);
    detail::draw_fluid_method(draw, scene);
    scene.max = {12, 8, scene.dimensions == 3 ? 4.0 : 0.0};
    detail::draw_basin(draw, scene);
    scene.materials.push_back(detail::draw_fluid(draw));
    detail::draw_fluid_bodies(draw, scene, fluid_kind(number));
    if (draw.with(0.15)) detail::draw_obstacle(draw, scene);
    for (BodySpec& body : scene.bodies) body.material = 0;
    scene.balance.interval = 20;
    scene.cfl = standard_courant(scene);
    return scene;
}

}  // namespace moraine::verification
