#pragma once
// S23: thin random scenes, number n: what long runouts end as. A film of 0.3 to 3 cells on a bed at any angle; a spray
// of droplets; droplets that fall on a wall, a plane, a sphere or an edge; a front that runs over steps. USL with every
// transfer, every wide shape, every law that needs no stress at the start, the whole default step, the default
// boundary. As in S22 (random_scene.hpp) all is drawn from n, h and rho are 1, c is near 1, speeds at most Mach 0.3.

#include "verification/random_scene.hpp"

namespace moraine::verification {

enum class ThinKind { film, spray, drop, front };

/// A scene's number decides its kind in turn.
inline ThinKind thin_kind(std::uint64_t number) {
    return static_cast<ThinKind>(number % 4);
}

inline const char* name_of(ThinKind kind) {
    constexpr const char* names[] = {"film", "spray", "drop", "front"};
    return names[static_cast<int>(kind)];
}

namespace detail {

inline void draw_thin_method(Draw& draw, Scene& scene) {
    constexpr Shape wide[] = {Shape::quadratic, Shape::quadratic, Shape::cubic, Shape::gimp, Shape::gimp_contiguous};
    constexpr Transfer transfers[] = {Transfer::flip, Transfer::apic, Transfer::tpic, Transfer::apic};
    scene.shape = wide[draw.below(5)];
    scene.transfer = transfers[draw.below(4)];
    scene.stress_update = StressUpdate::usl;
}

inline MaterialSpec draw_thin_material(Draw& draw) {
    const MaterialSpec drawn = draw_material(draw);  // of S22, by a law of its own
    if (!draw.with(0.5)) return drawn;
    const double nu = 0.495;  // runouts are nearly incompressible
    constexpr const char* fluids[] = {"newtonian", "bingham", "mu-i"};
    const int which = draw.below(3);
    const double viscosity = draw.with(0.3) ? 0 : draw.log_between(1e-4, 1e-1);
    std::map<std::string, double> values{{"young", young_for(1, nu)},
                                         {"poisson", nu},
                                         {"viscosity", viscosity},
                                         {"yield_stress", draw.log_between(1e-5, 1e-3)}};
    if (which == 2)
        values.insert(
            {{"static_friction", 0.38}, {"limit_friction", 0.64}, {"grain_diameter", 0.1}, {"grain_density", 1.6}});
    return material(fluids[which], 1, values);
}

/// Closed at the bottom, anything but open at the sides, so that all that leaves is an error.
inline void draw_basin(Draw& draw, Scene& scene) {
    constexpr WallKind kinds[] = {WallKind::no_slip, WallKind::free_slip, WallKind::friction};
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        for (WallSpec& wall : scene.walls[a]) {
            wall.kind = kinds[draw.below(3)];
            wall.friction = draw.between(0, 1);
        }
    if (scene.dimensions == 3 && draw.with(0.5)) make_periodic(scene, 2);
    if (draw.with(0.3)) scene.walls[0][1].kind = WallKind::open;
}

inline StructureSpec draw_surface(Draw& draw) {
    StructureSpec s;
    s.name = "bed";
    s.clear = true;
    s.law = static_cast<InterfaceLaw>(draw.below(3));
    s.friction = draw.between(0, 1);
    return s;
}

/// A distance to a surface: anything from a hair to a cell [cells].
inline double draw_height(Draw& draw) {
    return draw.with(0.3) ? 0 : draw.log_between(1e-6, 1);
}

inline void draw_gravity(Draw& draw, Scene& scene, double g) {
    const double angle = draw.with(0.4) ? 0 : draw.between(0, 0.6);
    scene.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
}

inline BodySpec block(const Scene& scene, Triple min, Triple max, double spacing) {
    BodySpec body;
    body.min = min, body.max = max;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        body.particles_per_cell[a] = static_cast<int>(std::ceil(1 / spacing));
    return body;
}

inline void draw_film(Draw& draw, Scene& scene) {
    const double thickness = draw.log_between(0.3, 3), floor = draw_height(draw);
    double bottom = floor;
    if (draw.with(0.5)) {  // on a plane inside the domain
        StructureSpec plane = draw_surface(draw);
        plane.normal = {0, 1, 0};
        plane.point = {0, draw.between(1, 2), 0};
        bottom += plane.point[1];
        scene.structures.push_back(plane);
    }
    const double from = draw.between(0, 0.3) * scene.max[0], to = draw.between(0.5, 1) * scene.max[0];
    BodySpec body = block(scene, {from, bottom, 0}, {to, bottom + thickness, scene.max[2]},
                          std::min(0.5, std::max(0.25, thickness)));
    if (draw.with(0.3)) body.seeding = Seeding::jittered, body.jitter = draw.between(0, 0.5);
    body.velocity[0] = draw.with(0.5) ? draw.between(0, 0.1) : 0;
    scene.bodies.push_back(body);
    draw_gravity(draw, scene, draw.log_between(1e-6, 1e-4));
}

inline BodySpec draw_droplet(Draw& draw, const Scene& scene, double speed) {
    BodySpec drop;
    drop.shape = BodyShape::sphere;
    drop.radius = draw.log_between(0.3, 1.5);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double room = scene.max[a] - 2 * drop.radius;
        drop.center[a] = drop.radius + room * draw.share();
        drop.velocity[a] = draw.between(-speed, speed);
        drop.particles_per_cell[a] = drop.radius < 0.6 ? 3 : 2;
    }
    return drop;
}

inline void draw_spray(Draw& draw, Scene& scene) {
    const int drops = 2 + draw.below(9);
    for (int k = 0; k < drops; ++k) scene.bodies.push_back(draw_droplet(draw, scene, 0.15));
    draw_gravity(draw, scene, draw.log_between(1e-6, 1e-3));
}

inline void draw_drop(Draw& draw, Scene& scene) {
    StructureSpec s = draw_surface(draw);
    const double middle = 0.5 * scene.max[0], deep = 0.5 * scene.max[2];
    switch (draw.below(4)) {
        case 1:
            s.normal = {draw.between(-0.7, 0.7), 1, 0};
            s.point = {middle, draw.between(1, 2), 0};
            break;
        case 2:
            s.shape = StructureShape::sphere;
            s.radius = draw.between(1.2, 2.5);
            s.center = {middle + draw.between(-1, 1), 0.5, deep};
            break;
        case 3:
            s.shape = StructureShape::box;
            s.min = {middle - 0.3, -1, -1}, s.max = {middle + draw.between(1, 2), draw.between(1, 2), scene.max[2] + 1};
            break;
        default:
            s.name.clear();  // on the wall
    }
    if (!s.name.empty()) scene.structures.push_back(s);
    BodySpec drop = draw_droplet(draw, scene, 0.05);
    drop.center = {middle + draw.between(-1, 1), 4.0 + drop.radius + draw_height(draw), deep};
    drop.velocity[1] = -draw.between(0.02, 0.25);
    scene.bodies.push_back(drop);
    draw_gravity(draw, scene, draw.log_between(1e-6, 1e-3));
}

inline void draw_front(Draw& draw, Scene& scene) {
    const double height = draw.between(1, 4), length = draw.between(2, 4);
    BodySpec body = block(scene, {0, 0, 0}, {length, height, scene.max[2]}, 0.5);
    body.velocity[0] = draw.between(0, 0.15);
    scene.bodies.push_back(body);
    StructureSpec step = draw_surface(draw);
    step.name = "step";
    step.shape = StructureShape::box;
    const double at = length + draw.between(0.5, 2);
    step.min = {at, -1, -1}, step.max = {at + draw.between(1, 3), draw.between(0.3, 1.5), scene.max[2] + 1};
    scene.structures.push_back(step);
    draw_gravity(draw, scene, draw.log_between(1e-4, 3e-3));
}

}  // namespace detail

inline Scene thin_scene(std::uint64_t number) {
    Draw draw(number + (std::uint64_t(1) << 32));  // not those of S22
    Scene scene = begin_scene("thin", number, draw);
    detail::draw_thin_method(draw, scene);
    scene.max = {12, 8, scene.dimensions == 3 ? 4.0 : 0.0};
    detail::draw_basin(draw, scene);
    scene.materials.push_back(detail::draw_thin_material(draw));
    switch (thin_kind(number)) {
        case ThinKind::film:
            detail::draw_film(draw, scene);
            break;
        case ThinKind::spray:
            detail::draw_spray(draw, scene);
            break;
        case ThinKind::drop:
            detail::draw_drop(draw, scene);
            break;
        case ThinKind::front:
            detail::draw_front(draw, scene);
            break;
    }
    for (BodySpec& body : scene.bodies) body.material = 0;
    scene.balance.interval = 20;
    scene.cfl = standard_courant(scene);
    return scene;
}

}  // namespace moraine::verification
