#include "step/costs.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/data/vec.hpp"

namespace moraine {

namespace {

/// Without cells where `by_cell` is false.
CostModel fit(const std::vector<ChildResult>& cases, bool by_cell) {
    Mat<double, 3> normal = zero_mat<double, 3>();
    Vec<double, 3> right = zero_vec<double, 3>();
    for (const ChildResult& r : cases) {
        const double cells = by_cell ? r.cells : 0;
        const double row[3] = {r.particles / r.step_seconds, cells / r.step_seconds, r.blocks / r.step_seconds};
        for (int i = 0; i < 3; ++i) {
            right[i] += row[i];
            for (int j = 0; j < 3; ++j) normal(i, j) += row[i] * row[j];
        }
    }
    if (!by_cell) normal(1, 1) = 1;
    const Mat<double, 3> solved = inverse(normal);
    double x[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) x[i] += 1e12 * solved(i, j) * right[j];
    return {std::llround(x[0]), std::llround(x[1]), std::llround(x[2])};
}

}  // namespace

CostModel fit_costs(const std::vector<ChildResult>& cases) {
    const CostModel model = fit(cases, true);
    return model.c < 0 ? fit(cases, false) : model;
}

std::string cost_table(const CostModel& model, const std::vector<Case>& names, const std::vector<ChildResult>& cases) {
    std::string text = fmt::format(
        "Cost of a block: {} ps per particle + {} ps per occupied cell + {} ps per block "
        "(3-D, quadratic, FLIP, USL, von Mises, double).\n\n"
        "| scene | particles | cells | blocks | measured [ms per step] | model | error "
        "|\n|---|---|---|---|---|---|---|\n",
        model.a, model.c, model.d);
    for (std::size_t k = 0; k < cases.size(); ++k) {
        const ChildResult& r = cases[k];
        const double fit = 1e-12 * (static_cast<double>(model.a) * r.particles +
                                    static_cast<double>(model.c) * r.cells + static_cast<double>(model.d) * r.blocks);
        text +=
            fmt::format("| {} | {:.0f} | {:.0f} | {:.0f} | {:.3f} | {:.3f} | {:+.1f} % |\n", names[k].name, r.particles,
                        r.cells, r.blocks, 1e3 * r.step_seconds, 1e3 * fit, 100 * (fit / r.step_seconds - 1));
    }
    return text;
}

}  // namespace moraine
