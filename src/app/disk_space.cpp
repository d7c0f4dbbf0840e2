#include "app/disk_space.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "predict/capacity.hpp"
#include "predict/prediction.hpp"

namespace moraine {

double free_disk_bytes(const std::string& directory) {
    std::filesystem::path path = std::filesystem::absolute(directory);
    std::error_code none;
    while (!std::filesystem::exists(path, none) && path.has_relative_path()) path = path.parent_path();
    const auto space = std::filesystem::space(path, none);
    return none ? 0 : static_cast<double>(space.available);
}

std::string disk_warning(const Scene& scene, double time, double free_bytes) {
    if (free_bytes <= 0 || scene.output.deflate || scene.output.on_cells || !(scene.end > time)) return {};
    Prediction p = estimate(scene);
    p.steps = 1e15;
    const OutputPrediction o = predict_output(scene, p);
    const double bytes = o.row_bytes * o.rows * (1 + (o.outputs - 1) * (scene.end - time) / scene.end);
    if (bytes <= free_bytes) return {};
    return fmt::format(
        "outputs to t = {:.6g} s may take {:.3g} GB (the disk has {:.3g} GB free). A longer output.interval, "
        "--no-particles, or another --output?",
        scene.end, bytes / 1e9, free_bytes / 1e9);
}

}  // namespace moraine
