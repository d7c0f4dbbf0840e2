#pragma once
// S28: random scenes of saturated soil, number n: beds at rest, columns that fall apart, slopes, blocks that fly into
// corners, beds under a dry cap. Every law and transfer that takes water, 1 to 20 cells deep, conductivities of 1e-9 to
// 1e-2 m/s, waters of 10 MPa to 2.2 GPa, closed and open walls, dry or under water, up to the whole default step. All
// is drawn from n; gravity is that of a centrifuge, so that much happens in few steps.

#include "verification/fluid_scene.hpp"

namespace moraine::verification {

enum class WetKind { bed, column, slope, corner, cap };

/// A scene's number decides its kind in turn.
inline WetKind wet_kind(std::uint64_t number) {
    return static_cast<WetKind>(number % 5);
}

inline const char* name_of(WetKind kind) {
    constexpr const char* names[] = {"bed", "column", "slope", "corner", "cap"};
    return names[static_cast<int>(kind)];
}

namespace detail {

inline MaterialSpec draw_grains(Draw& draw, const char* law, double density) {
    return material(law, density,
                    {{"young", draw.log_between(1e5, 1e8)},
                     {"poisson", draw.between(0, 0.45)},
                     {"friction_angle", draw.between(15, 40)},
                     {"dilation_angle", draw.with(0.5) ? 0 : draw.between(0, 10)},
                     {"cohesion", draw.with(0.5) ? 0 : draw.log_between(10, 1e4)},
                     {"static_friction", 0.38},
                     {"limit_friction", 0.64},
                     {"grain_diameter", draw.log_between(1e-4, 1e-2)},
                     {"grain_density", 2650}});
}

inline MaterialSpec draw_wet_soil(Draw& draw, const Scene& scene) {
    constexpr const char* laws[] = {"linear-elastic", "neo-hookean", "drucker-prager", "drucker-prager", "mu-i"};
    const double porosity = draw.between(0.2, 0.6);
    MaterialSpec m = draw_grains(draw, laws[draw.below(5)], (1 - porosity) * 2650 + porosity * scene.water.density);
    m.porosity = porosity;
    m.conductivity = draw.log_between(1e-9, 1e-2);
    m.volumetric = Volumetric::grid;
    return m;
}

inline void draw_drainage(Draw& draw, Scene& scene) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        for (WallSpec& wall : scene.walls[a])
            if (wall.kind != WallKind::periodic && wall.kind != WallKind::open) wall.drains = draw.with(0.3);
}

/// From floor to top [cells], across all of the domain or a part of it.
inline BodySpec wet_box(Draw& draw, const Scene& scene, double from, double to, double bottom, double top) {
    BodySpec body;
    body.min = {from * scene.cell, bottom * scene.cell, 0};
    body.max = {to * scene.cell, top * scene.cell, scene.max[2]};
    draw_filling(draw, scene, body);
    return body;
}

/// Still water up to the top of the soil, or above it.
inline void draw_table(Draw& draw, Scene& scene, double top) {
    scene.water.submerged = draw.with(0.4);
    scene.water.table = top * scene.cell + (scene.water.submerged ? draw.between(0, 10) : 0);
}

inline void draw_wet_bodies(Draw& draw, Scene& scene, WetKind kind, double depth) {
    const double width = scene.max[0] / scene.cell;
    const double part = width * draw.between(0.3, 0.7);
    switch (kind) {
        case WetKind::bed:
        case WetKind::cap:
            scene.bodies.push_back(wet_box(draw, scene, 0, width, 0, depth));
            break;
        case WetKind::column:
            scene.bodies.push_back(wet_box(draw, scene, 0, part, 0, depth));
            break;
        case WetKind::slope:
            scene.bodies.push_back(wet_box(draw, scene, draw.with(0.5) ? 0 : 1, part + 1, 0, depth));
            break;
        case WetKind::corner:
            scene.bodies.push_back(wet_box(draw, scene, 1, 1 + part, draw_height(draw), depth + 1));
            break;
    }
    BodySpec& body = scene.bodies.front();
    if (kind == WetKind::corner) {
        const double speed = 0.05 * std::sqrt(scene.materials[0].parameters[0] / scene.materials[0].density);
        body.velocity = {-draw.between(0, speed), -draw.between(0, speed), 0};
    }
    if (kind == WetKind::slope || kind == WetKind::corner) return;
    draw_table(draw, scene, depth);
    body.geostatic = draw.with(0.7), body.geostatic_surface = depth * scene.cell;
    if (kind != WetKind::cap) return;
    scene.bodies.push_back(wet_box(draw, scene, 0, part, depth, depth + draw.between(0.5, 3)));
    scene.bodies.back().material = 1;
}

}  // namespace detail

inline Scene wet_scene(std::uint64_t number) {
    using namespace detail;
    Draw draw(number + (std::uint64_t(1) << 34));  // not those of S22 to S24
    Scene scene = begin_scene("wet", number, draw);
    constexpr Transfer transfers[] = {Transfer::flip, Transfer::pic, Transfer::apic, Transfer::tpic, Transfer::aflip};
    scene.shape = Shape::quadratic;
    scene.transfer = transfers[draw.below(5)];
    scene.flip = standard_flip(scene.transfer);
    scene.stress_update = StressUpdate::usl;
    scene.cell = draw.log_between(0.02, 0.5);
    const bool deep = scene.dimensions == 3;
    const double depth = draw.log_between(1, deep ? 6 : 20), width = 4 * (1 + draw.below(deep ? 2 : 3));
    scene.max = {width * scene.cell, 4 * std::ceil((depth + 5) / 4) * scene.cell, deep ? 4 * scene.cell : 0};
    draw_basin(draw, scene);
    draw_drainage(draw, scene);
    scene.water.on = true;
    scene.water.bulk = draw.log_between(1e7, 2.2e9);
    scene.materials.push_back(draw_wet_soil(draw, scene));
    scene.materials.push_back(draw_grains(draw, "drucker-prager", draw.between(1400, 1900)));
    const WetKind kind = wet_kind(number);
    const double g = 9.81 * draw.log_between(1, 30), tilt = kind == WetKind::slope ? draw.between(0, 0.6) : 0;
    scene.gravity = {g * std::sin(tilt), -g * std::cos(tilt), 0};
    draw_wet_bodies(draw, scene, kind, depth);
    scene.balance.interval = 20;
    scene.cfl = standard_courant(scene) * (draw.with(0.5) ? 1 : draw.between(0.2, 1));
    return scene;
}

}  // namespace moraine::verification
