// What particles.vtkhdf or cells.vtkhdf will hold (predict/prediction.hpp): the columns of records/output_frame.hpp or
// records/cell_frame.hpp, counted.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/particles/particle_state.hpp"
#include "predict/prediction.hpp"

namespace moraine {

namespace {

/// Numbers of a field in the file; vectors of 2-D scenes have a third.
template <int Dim>
int components_of(const std::string& field) {
    int components = 1;  // what is derived, and what a law remembers
    each_variable<double, Dim>([&](const auto& v) {
        if (field == v.name) components = v.components();
    });
    return components == 2 ? 3 : components;
}

int field_bytes(const Scene& scene, const std::string& field) {
    if (field == "body") return 2;
    const bool derived = scene.output.on_cells || field == "pressure" || field == "density";
    const bool single = scene.output.single || (!derived && scene.precision == Precision::single_);
    return (single ? 4 : 8) * (scene.dimensions == 2 ? components_of<2>(field) : components_of<3>(field));
}

}  // namespace

OutputPrediction predict_output(const Scene& scene, const Prediction& p) {
    OutputPrediction o;
    const bool cells = scene.output.on_cells;
    o.row_bytes = scene.output.single ? 12 : 24;  // the place
    if (cells) o.row_bytes += scene.output.single ? 4 : 8;
    for (const std::string& label : scene.output.labels)
        if (!cells || label != "id") o.row_bytes += label == "rank" ? 4 : 8;
    for (const std::string& field : scene.output.fields) o.row_bytes += field_bytes(scene, field);
    o.rows = cells ? p.cells : std::ceil(static_cast<double>(p.particles) / static_cast<double>(scene.output.every));
    const double interval = scene.output.interval;
    const double times = interval > 0 ? std::ceil(scene.end / interval * (1 - 1e-12)) : 1;
    o.outputs = 1 + std::min(times, std::ceil(p.steps));
    o.steps = o.outputs > 1 ? p.steps / (o.outputs - 1) : 0;
    return o;
}

}  // namespace moraine
