#pragma once
// S22: scene number n of the fuzz. Everything is drawn from n: dimensions, shape, transfer, scheme, law and its
// parameters, seeding, walls or periodic axes, gravity, drift, damping, structures, and the step as a share of what
// stands in `cfl`. h and rho are 1 and c is near 1. At most some thousand particles, at speeds of at most Mach 0.3.

#include <cmath>
#include <cstdint>

#include "verification/run.hpp"

namespace moraine::verification {

/// Numbers that depend on the seed alone (splitmix64).
class Draw {
  public:
    explicit Draw(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u) {}

    double share() {  ///< [0, 1)
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return std::ldexp(static_cast<double>((z ^ (z >> 31)) >> 11), -53);
    }
    double between(double low, double high) { return low + (high - low) * share(); }
    double log_between(double low, double high) { return low * std::pow(high / low, share()); }
    int below(int n) { return static_cast<int>(share() * n); }
    bool with(double probability) { return share() < probability; }

  private:
    std::uint64_t state_;
};

inline void draw_method(Draw& draw, Scene& scene) {
    scene.shape = static_cast<Shape>(draw.below(5));
    scene.transfer = static_cast<Transfer>(draw.below(4));
    scene.stress_update = static_cast<StressUpdate>(draw.below(3));
    const bool affine = scene.transfer == Transfer::apic || scene.transfer == Transfer::tpic;
    if (scene.shape == Shape::linear && affine) scene.transfer = Transfer::flip;  // refused otherwise
    if (draw.with(0.2)) scene.flip = draw.between(0.9, 1);
    if (draw.with(0.1)) scene.damping = draw.between(0, 0.3);
    scene.boundary_spline = draw.with(0.8);
}

/// Young's modulus for waves of speed c at rho = 1.
inline double young_for(double c, double nu) {
    return c * c * (1 + nu) * (1 - 2 * nu) / (1 - nu);
}

inline MaterialSpec draw_material(Draw& draw) {
    constexpr const char* laws[] = {"linear-elastic", "neo-hookean", "von-mises",        "tresca",
                                    "bingham",        "newtonian",   "herschel-bulkley", "drucker-prager"};
    const std::string law = laws[draw.below(8)];
    const double nu = draw.between(0, 0.49), c = draw.log_between(0.5, 1);
    const double strength = draw.log_between(1e-4, 1e-2);
    std::map<std::string, double> values{{"young", young_for(c, nu)},
                                         {"poisson", nu},
                                         {"su", strength},
                                         {"yield_stress", strength},
                                         {"viscosity", draw.log_between(1e-4, 1)},
                                         {"consistency", draw.log_between(1e-4, 1)},
                                         {"exponent", draw.between(0.3, 1)},
                                         {"friction_angle", draw.between(10, 40)},
                                         {"dilation_angle", draw.between(0, 10)},
                                         {"cohesion", strength}};
    if (draw.with(0.3)) values.insert({{"sensitivity", draw.between(1, 5)}, {"xi95", draw.between(1, 10)}});
    return material(law, 1, values);
}

inline void draw_walls(Draw& draw, Scene& scene) {
    constexpr WallKind kinds[] = {WallKind::no_slip, WallKind::free_slip, WallKind::friction, WallKind::open};
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        if (draw.with(0.3)) {
            make_periodic(scene, a);
            continue;
        }
        for (WallSpec& wall : scene.walls[a]) {
            wall.kind = kinds[draw.below(4)];
            wall.friction = draw.between(0, 1);
        }
    }
}

/// In a part of the domain: anything between the whole and a third of each axis.
inline BodySpec draw_body(Draw& draw, const Scene& scene, double from, double to) {
    BodySpec body;
    const int per_cell = scene.dimensions == 2 ? 1 + draw.below(3) : 1 + draw.below(2);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double low = a == 0 ? from * scene.max[0] : 0, high = a == 0 ? to * scene.max[0] : scene.max[a];
        const double length = draw.with(0.4) ? high - low : (high - low) * draw.between(0.34, 1);
        body.min[a] = low + (high - low - length) * draw.share();
        body.max[a] = body.min[a] + length;
        body.particles_per_cell[a] = per_cell;
        body.velocity[a] = draw.with(0.7) ? draw.between(-0.1, 0.1) : 0;
    }
    if (draw.with(0.5)) body.seeding = Seeding::jittered, body.jitter = draw.between(0, 0.5);
    if (draw.with(0.5)) {
        body.wave.wavelength = draw.between(3, 16);
        body.wave.axis = draw.below(scene.dimensions);
        for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
            body.wave.velocity[a] = draw.between(-0.01, 0.01);
    }
    return body;
}

/// A fixed sphere or half-space in a corner, which takes away the particles that begin in it.
inline void draw_structure(Draw& draw, Scene& scene) {
    StructureSpec s;
    s.name = "obstacle";
    s.law = static_cast<InterfaceLaw>(draw.below(3));
    s.friction = draw.between(0, 1);
    s.clear = true;
    if (draw.with(0.5)) {
        s.shape = StructureShape::sphere;
        s.radius = 0.2 * scene.max[0];
    } else {
        s.normal = {0.6, 0.8, 0};
        s.point = {0.1 * scene.max[0], 0.1 * scene.max[1], 0};
    }
    scene.structures.push_back(s);
}

/// A cell of 1, in 2-D or 3-D; the first draw of all random scenes.
inline Scene begin_scene(const char* name, std::uint64_t number, Draw& draw) {
    Scene scene;
    scene.name = name;
    scene.seed = number;
    scene.dimensions = draw.with(0.4) ? 3 : 2;
    scene.cell = 1;
    return scene;
}

inline Scene random_scene(std::uint64_t number) {
    Draw draw(number);
    Scene scene = begin_scene("random", number, draw);
    draw_method(draw, scene);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        scene.max[a] = 4 * (scene.dimensions == 2 ? 2 + draw.below(4) : 1 + draw.below(3));
    draw_walls(draw, scene);
    scene.materials.push_back(draw_material(draw));
    if (draw.with(0.4)) {
        scene.materials.push_back(draw_material(draw));
        scene.bodies.push_back(draw_body(draw, scene, 0, 0.5));
        scene.bodies.push_back(draw_body(draw, scene, 0.5, 1));
        scene.bodies[1].material = 1;
    } else {
        scene.bodies.push_back(draw_body(draw, scene, 0, 1));
    }
    if (draw.with(0.5))
        for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
            scene.gravity[a] = draw.between(-1e-3, 1e-3);
    bool periodic = false;
    for (bool p : scene.periodic) periodic = periodic || p;
    if (!periodic && draw.with(0.2)) draw_structure(draw, scene);
    scene.balance.interval = 20;
    return scene;
}

/// The share of the program's own step that scene `number` takes.
inline double random_share(std::uint64_t number) {
    return Draw(~number).between(0.2, 0.9);
}

}  // namespace moraine::verification
