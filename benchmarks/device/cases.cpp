#include "device/cases.hpp"

#include <algorithm>
#include <cmath>

#include "core/material/laws.hpp"

namespace moraine {

namespace {

/// For a thousand steps and more: a hundred times as stiff and strong, so that the column shears and yields but does
/// not fall apart; it slides by 1.6 % of a cell per step.
Scene lasting(Scene s) {
    MaterialSpec& m = s.materials.front();
    const std::span<const Parameter> keys = find_law(m.law)->parameters;
    for (std::size_t k = 0; k < keys.size(); ++k)
        if (std::string(keys[k].unit) == "Pa") m.parameters[k] *= 100;
    s.bodies.front().velocity[0] = 12;
    s.bodies.front().wave.velocity[static_cast<std::size_t>(s.dimensions - 1)] = 3;
    return s;
}

/// 5 cells thick and square, on the floor: partly filled blocks, hardly a full one.
Scene slab(const ColumnOptions& o, double particles) {
    Scene s = column_case(o, 8).scene;
    const double edge = std::round(std::sqrt(particles / (8 * 5)));
    const double side = 4 * std::ceil(edge / 4) + 16;
    s.max = {side, side, 24};
    BodySpec& body = s.bodies.front();
    body.min = {std::round(0.5 * (side - edge)), std::round(0.5 * (side - edge)), 0};
    body.max = {body.min[0] + edge, body.min[1] + edge, 5};
    return s;
}

/// Along x one cube of `particles` for each rank.
Scene bar(const ColumnOptions& o, double particles, int ranks) {
    Scene s = column_case(o, particles).scene;
    BodySpec& body = s.bodies.front();
    const double longer = (ranks - 1) * (body.max[0] - body.min[0]);
    s.max[0] += 4 * std::ceil(longer / 4);
    body.max[0] += longer;
    return s;
}

/// A column of layers, each `thickness` cells high and of the next of these laws; all of them begin alike.
Scene layers(ColumnOptions o, double particles, const std::vector<const char*>& laws, double thickness) {
    Scene s;
    std::vector<MaterialSpec> materials;
    for (const char* law : laws) {
        o.law = law;
        s = lasting(column_case(o, particles).scene);
        materials.push_back(s.materials.front());
    }
    s.materials = materials;
    BodySpec layer = s.bodies.front();
    const auto up = static_cast<std::size_t>(o.dimensions - 1);
    const double top = layer.max[up];
    s.bodies.clear();
    for (double z = layer.min[up]; z < top; z = layer.max[up]) {
        layer.min[up] = z, layer.max[up] = std::min(z + thickness, top);
        layer.material = static_cast<int>(s.bodies.size() % laws.size());
        s.bodies.push_back(layer);
    }
    return s;
}

struct Size {
    const char* name;
    double particles;
};

/// Two materials, each alone, in two layers, and in layers so thin that every block has both.
void add_materials(std::vector<DeviceCase>& cases, ColumnOptions o, const std::string& tail) {
    for (const Size& size : {Size{"8M", 100.0 * 100 * 100 * 8}, Size{"200k", 29.0 * 29 * 29 * 8}})
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            o.transfer = transfer;
            const double half = std::ceil(0.5 * std::cbrt(size.particles / 8));
            const auto add = [&](const char* kind, const std::vector<const char*>& laws, double thickness) {
                cases.push_back({std::string("materials-") + size.name + "-" + kind +
                                     (transfer == Transfer::apic ? "-apic-" : "-flip-") + tail,
                                 layers(o, size.particles, laws, thickness), false});
            };
            add("clay", {"von-mises"}, 1e6);
            add("sand", {"drucker-prager"}, 1e6);
            add("layers", {"drucker-prager", "von-mises"}, half);
            add("thin", {"drucker-prager", "von-mises"}, 2);
        }
}

}  // namespace

std::vector<DeviceCase> device_cases(int ranks) {
    std::vector<DeviceCase> cases;
    for (Precision precision : {Precision::single_, Precision::double_}) {
        const std::string tail = precision == Precision::single_ ? "single" : "double";
        ColumnOptions o;
        o.precision = precision;
        for (const Size& size : {Size{"column-16M", 128.0 * 128 * 128 * 8}, Size{"column-2M", 64.0 * 64 * 64 * 8},
                                 Size{"column-200k", 29.0 * 29 * 29 * 8}})
            cases.push_back({std::string(size.name) + "-" + tail, lasting(column_case(o, size.particles).scene),
                             size.particles < 3e6});
        for (const Size& size : {Size{"weak-16M", 128.0 * 128 * 128 * 8}, Size{"weak-2M", 64.0 * 64 * 64 * 8}})
            cases.push_back({std::string(size.name) + "-" + tail, lasting(bar(o, size.particles, ranks)), false});
        cases.push_back({"slab-8M-" + tail, lasting(slab(o, 8e6)), false});
        cases.push_back({"column-64M-" + tail, lasting(column_case(o, 200.0 * 200 * 200 * 8).scene), false});
        for (Case& c : cost_cases(2e6)) {
            c.scene.precision = precision;
            std::erase(c.name, ',');
            std::replace(c.name.begin(), c.name.end(), ' ', '-');
            cases.push_back({"costs-" + c.name + "-" + tail, lasting(c.scene), false});
        }
        for (const Case& c : all_cases(96.0 * 96 * 96 * 8))
            if (c.scene.precision == precision) cases.push_back({"7M-" + c.name, lasting(c.scene), false});
        add_materials(cases, o, tail);
    }
    return cases;
}

}  // namespace moraine
