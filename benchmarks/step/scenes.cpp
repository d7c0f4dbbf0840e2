#include "step/scenes.hpp"

#include <cmath>
#include <map>

#include "core/material/laws.hpp"

namespace moraine {

namespace {

const char* text_of(Shape shape) {
    switch (shape) {
        case Shape::linear:
            return "linear";
        case Shape::gimp:
            return "gimp";
        case Shape::gimp_contiguous:
            return "gimp-contiguous";
        case Shape::cubic:
            return "cubic";
        default:
            return "quadratic";
    }
}

const char* text_of(Transfer transfer) {
    return transfer == Transfer::apic   ? "apic"
           : transfer == Transfer::tpic ? "tpic"
           : transfer == Transfer::fmpm ? "fmpm"
                                        : "flip";
}

const char* text_of(StressUpdate scheme) {
    return scheme == StressUpdate::usf ? "usf" : (scheme == StressUpdate::musl ? "musl" : "usl");
}

/// A soft clay, or a mud or sand of the same stiffness.
MaterialSpec material(const std::string& law) {
    const std::map<std::string, double> values = {{"young", 1e6},      {"poisson", 0.4},      {"su", 2000},
                                                  {"consistency", 50}, {"viscosity", 50},     {"yield_stress", 500},
                                                  {"exponent", 0.7},   {"friction_angle", 30}};
    MaterialSpec m;
    m.name = m.law = law;
    m.density = 1500;
    for (const Parameter& p : find_law(law)->parameters) {
        const auto it = values.find(p.key);
        m.parameters.push_back(it == values.end() ? p.standard : it->second);
    }
    return m;
}

double edge_cells(const ColumnOptions& o, double particles) {
    double per_cell = 1;
    for (int a = 0; a < o.dimensions; ++a) per_cell *= o.particles_per_cell[static_cast<std::size_t>(a)];
    return std::round(std::pow(particles / per_cell, 1.0 / o.dimensions));
}

BodySpec box(const ColumnOptions& o, const Triple& min, const Triple& max) {
    BodySpec b;
    b.min = min;
    b.max = max;
    b.particles_per_cell = o.particles_per_cell;
    b.velocity = {2, 0, 0};
    b.wave.velocity[static_cast<std::size_t>(o.dimensions - 1)] = 0.5;
    b.wave.wavelength = 16;
    return b;
}

/// Everything but the bodies: a domain of `edge` x 2 cells, in whole blocks along the periodic axis.
Scene empty_scene(const ColumnOptions& o, double edge) {
    Scene s;
    s.dimensions = o.dimensions;
    s.precision = o.precision;
    s.shape = o.shape;
    s.transfer = o.transfer;
    s.stress_update = o.stress_update;
    s.cell = 1;
    s.cfl = o.shape == Shape::linear
                ? 0.2
                : (o.transfer == Transfer::fmpm ? 0.3 : 0.5);  // sheared clay on hat functions turns inside out at 0.3
    s.end = 1e6;
    s.gravity[static_cast<std::size_t>(o.dimensions - 1)] = -9.81;
    const double side = 4 * std::ceil(edge / 2) + 8;
    for (std::size_t a = 0; a < static_cast<std::size_t>(o.dimensions); ++a) {
        s.max[a] = side;
        s.walls[a][0].kind = s.walls[a][1].kind = a == 0 ? WallKind::periodic : WallKind::free_slip;
        s.periodic[a] = a == 0;
    }
    s.materials.push_back(material(o.law));
    s.materials.back().volumetric = o.volumetric;
    return s;
}

std::string name_of(const ColumnOptions& o) {
    return std::to_string(o.dimensions) + "d-" + text_of(o.shape) + "-" + text_of(o.transfer) + "-" +
           text_of(o.stress_update) + "-" + o.law + (o.volumetric == Volumetric::cell ? "-cell-volumetric" : "") +
           (o.precision == Precision::double_ ? "-double" : "-single");
}

}  // namespace

Case column_case(const ColumnOptions& o, double particles) {
    const double edge = std::max(1.0, edge_cells(o, particles));
    Scene s = empty_scene(o, edge);
    Triple min{}, max{};
    for (std::size_t a = 0; a < static_cast<std::size_t>(o.dimensions); ++a) {
        min[a] = static_cast<int>(a) == o.dimensions - 1 ? 0 : std::round(0.5 * (s.max[a] - edge));
        max[a] = min[a] + edge;
    }
    s.bodies.push_back(box(o, min, max));
    return {name_of(o), s};
}

std::vector<Case> target_cases(double particles) {
    ColumnOptions single;
    single.precision = Precision::single_;
    return {column_case({}, particles), column_case(single, particles)};
}

std::vector<Case> all_cases(double particles) {
    std::vector<ColumnOptions> list;
    for (Shape shape : {Shape::quadratic, Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::cubic}) {
        list.emplace_back();
        list.back().shape = shape;
    }
    for (Transfer transfer : {Transfer::apic, Transfer::tpic, Transfer::fmpm}) {
        list.emplace_back();
        list.back().transfer = transfer;
    }
    for (StressUpdate scheme : {StressUpdate::usf, StressUpdate::musl}) {
        list.emplace_back();
        list.back().stress_update = scheme;
    }
    for (const char* law : {"linear-elastic", "neo-hookean", "tresca", "herschel-bulkley", "drucker-prager"}) {
        list.emplace_back();
        list.back().law = law;
    }
    for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
        list.emplace_back();
        list.back().transfer = transfer;
        list.back().volumetric = Volumetric::cell;
    }
    list.emplace_back();
    list.back().dimensions = 2;
    std::vector<Case> cases;
    for (Precision precision : {Precision::double_, Precision::single_})
        for (ColumnOptions o : list) {
            o.precision = precision;
            cases.push_back(column_case(o, particles));
        }
    return cases;
}

std::vector<Case> cost_cases(double particles) {
    std::vector<Case> cases;
    for (const auto& ppc : {std::array{1, 1, 1}, std::array{2, 1, 1}, std::array{2, 2, 2}, std::array{3, 3, 3}}) {
        ColumnOptions o;
        o.particles_per_cell = ppc;
        cases.push_back(column_case(o, particles));
        cases.back().name = std::to_string(ppc[0] * ppc[1] * ppc[2]) + " per cell, dense";
    }
    const ColumnOptions o;
    Case layer{"8 per cell, a layer of one cell", empty_scene(o, 96)};
    layer.scene.bodies.push_back(box(o, {4, 4, 20}, {180, 180, 21}));
    cases.push_back(layer);
    Case crumbs{"8 per cell, single cells", empty_scene(o, 56)};
    for (int x = 0; x < 12; ++x)
        for (int y = 0; y < 12; ++y)
            for (int z = 0; z < 12; ++z) {
                const Triple at = {8.0 * x + 8, 8.0 * y + 8, 8.0 * z + 8};
                crumbs.scene.bodies.push_back(box(o, at, {at[0] + 1, at[1] + 1, at[2] + 1}));
            }
    cases.push_back(crumbs);
    return cases;
}

}  // namespace moraine
