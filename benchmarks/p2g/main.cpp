// benchmark_p2g: the laboratory of particle-to-grid transfers on the host.
//
//   benchmark_p2g [--blocks N] [--runs N] [--write DIR]
//
// Every variant sums the same particles (a cube of N^3 full blocks, 3-D, quadratic, FLIP), is checked
// against a plain reference in double, then timed; the runs of the variants are interleaved. --write
// puts the table into DIR/results.md and the JSON lines into DIR/results.jsonl.

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>

#include "machine.hpp"
#include "p2g/lanes.hpp"
#include "p2g/reference.hpp"
#include "p2g/shared.hpp"

namespace moraine {

namespace {

struct Options {
    int blocks = 12;
    int runs = 5;
    std::string write;
};

template <class Real>
struct Laboratory {
    explicit Laboratory(int blocks)
        : sample(blocks), tiles(sample), lists(sample), grid(sample.grid_nodes() * node_reals, Real(0)) {
        const auto bring_tiles = [this](GridSums<Real>& to) { tiles.bring(to); };
        const auto nothing = [](GridSums<Real>&) {};
        const double reads = read_bytes<Real>;
        const double tile = 2 * tile_bytes<Real>;
        const double nodes = 2.0 * node_reals * sizeof(Real) / Sample<Real>::per_cell;
        variants = {
            {"the program", [this] { sum_program(); }, bring_tiles, reads + tile, "what src/core/p2g.hpp does"},
            {"cell sums, factors shared along a row", [this] { sum_cells<Real, true>(tiles); }, bring_tiles,
             reads + tile, "three fused multiply-adds per node, no weight is multiplied out"},
            {"cell sums, weights at every node", [this] { sum_cells<Real, false>(tiles); }, bring_tiles, reads + tile,
             "four fused multiply-adds and four scalar products with broadcasts per node"},
            {"cell sums, scalar", [this] { sum_scalars(tiles); }, bring_tiles, reads + tile,
             "thirteen fused multiply-adds per node instead of four registers' worth"},
            {"cell sums, particles as lanes", [this] { sum_lanes(tiles); }, bring_tiles, reads + tile,
             "a cell's sums fill 6 KiB, a cell has too few particles, and each node ends with a sum across lanes"},
            {"particle by particle into the tile", [this] { sum_straight(tiles); }, bring_tiles, reads + tile,
             "a little faster in one thread (no second pass over sums of a cell); on a device it needs atomics, and "
             "the order of a sum is that of the "
             "list"},
            {"scatter to the shared grid", [this] { scatter(sample, grid); }, nothing, reads + nodes,
             "nodes of neighbour rows lie far apart; a second thread or rank needs atomics or colours"},
            {"atomics on the shared grid, 2 threads", [this] { scatter_atomic(sample, grid, 2); }, nothing,
             reads + nodes, "seven locked operations per node; the order of a sum is an accident", 2},
            {"node-wise gather, lists made", [this] { lists.make(sample), lists.gather(sample, grid); }, nothing,
             27 * (2 * 8 + reads / Sample<Real>::per_cell) + nodes,
             "each particle is read and its weights are made 27 times; lists of 27 entries per particle are made each "
             "step"},
            {"node-wise gather, lists given", [this] { lists.gather(sample, grid); }, nothing,
             27 * (8 + reads / Sample<Real>::per_cell) + nodes, "as above, without the making of the lists"},
        };
    }

    void sum_program() {
        const TileView<Real> view{sample.tile_of.data(), tiles.sums.data(), nullptr, nullptr};
        const ParticlesToGrid<Real, 3, Quadratic, false> kernel{
            sample.context(), sample.view(), sample.table(), sample.list(), view, sample.every_block.data(), Real(1)};
        const auto scratch = std::make_unique<typename ParticlesToGrid<Real, 3, Quadratic, false>::Scratch>();
        for (int b = 0; b < sample.blocks(); ++b) kernel(SoloTeam{}, b, *scratch);
    }

    Sample<Real> sample;
    Tiles<Real> tiles;
    NodeLists<Real> lists;
    GridSums<Real> grid;
    std::vector<Variant<Real>> variants;
};

/// Memory copied on one core [bytes/s], read and written: what a variant that only waits for memory would reach.
double copy_rate() {
    std::vector<char> from(1 << 28, 1), to(1 << 28, 0);
    std::vector<double> seconds;
    for (int r = 0; r < 5; ++r) {
        const double start = wall_seconds();
        std::memcpy(to.data(), from.data(), from.size());
        seconds.push_back(wall_seconds() - start);
        from[static_cast<std::size_t>(r)] = to[static_cast<std::size_t>(r) + 7];
    }
    return 2.0 * static_cast<double>(from.size()) / spread_of(seconds).median;
}

template <class Real>
void compare(const Options& o, double copied, std::string& table, std::string& json) {
    const bool single = sizeof(Real) == 4;
    Laboratory<Real> lab(o.blocks);
    const std::vector<double> reference = reference_sums(lab.sample);
    std::vector<std::vector<double>> sum(lab.variants.size()), bring(lab.variants.size());
    std::vector<double> error(lab.variants.size());
    for (int r = -1; r < o.runs; ++r)
        for (std::size_t v = 0; v < lab.variants.size(); ++v) {
            const double start = wall_seconds();
            lab.variants[v].sum();
            const double summed = wall_seconds();
            lab.variants[v].bring(lab.grid);
            const double brought = wall_seconds();
            if (r < 0)
                error[v] = relative_error(lab.grid, reference);
            else
                sum[v].push_back(summed - start), bring[v].push_back(brought - summed);
            if (r < 0 && !(error[v] < (single ? 1e-5 : 1e-12)))
                throw std::runtime_error(
                    fmt::format("{} is wrong by {:.2e} (relative)", lab.variants[v].name, error[v]));
        }
    const double n = lab.sample.particles();
    const double program = spread_of(sum[0]).median + spread_of(bring[0]).median;
    for (std::size_t v = 0; v < lab.variants.size(); ++v) {
        const Spread s = spread_of(sum[v]);
        const double b = spread_of(bring[v]).median;
        const double rate = lab.variants[v].bytes * n / s.median;
        table += fmt::format("| {} | {} | {:.1f} | {:.1f} % | {:.1f} | {:.2f} | {:.0f} | {:.0f} % | {:.1e} | {} |\n",
                             lab.variants[v].name, single ? "single" : "double", 1e9 * s.median / n,
                             100 * s.deviation / s.median, 1e9 * b / n, (s.median + b) / program, lab.variants[v].bytes,
                             100 * rate / copied, error[v], lab.variants[v].why);
        json += fmt::format(
            R"({{"benchmark": "p2g", "scene": "{} blocks, {}", "variant": "{}", {}, "ranks": 1, "threads": {}, "work_items": {:.0f}, )"
            R"("runs": {}, "median_s": {:.6f}, "spread_s": {:.6f}, "tiles_to_grid_s": {:.6f}, "bytes": {:.0f}, "error": {:.2e}}})"
            "\n",
            o.blocks, single ? "single" : "double", lab.variants[v].name, machine_json(this_machine()),
            lab.variants[v].threads, n, o.runs, s.median, s.deviation, b, lab.variants[v].bytes * n, error[v]);
    }
}

void run(const Options& o) {
    const double copied = copy_rate();
    std::string json;
    std::string table = fmt::format(
        "{}\n\nOne core copies {:.1f} GB/s (read and written). {} particles, median of {} runs.\n\n"
        "| variant | precision | sum [ns per particle] | spread | tiles to grid [ns] | time over the program's | bytes "
        "per particle "
        "| of copy rate | error | why |\n|---|---|---|---|---|---|---|---|---|---|\n",
        machine_sentence(this_machine()), 1e-9 * copied, o.blocks * o.blocks * o.blocks * 512, o.runs);
    compare<double>(o, copied, table, json);
    compare<float>(o, copied, table, json);
    fmt::print("{}\n{}", table, json);
    if (o.write.empty()) return;
    std::ofstream(o.write + "/results.md") << "# Particle-to-grid transfers on the host\n\nThe program's transfer and "
                                              "the rejected variants, timed side by "
                                              "side by `benchmark_p2g --write DIR`.\n\n"
                                           << table;
    std::ofstream(o.write + "/results.jsonl") << json;
}

}  // namespace

}  // namespace moraine

int main(int argc, char** argv) {
    try {
        moraine::Options options;
        for (int i = 1; i + 1 < argc; i += 2) {
            const std::string key = argv[i];
            if (key == "--blocks")
                options.blocks = std::stoi(argv[i + 1]);
            else if (key == "--runs")
                options.runs = std::stoi(argv[i + 1]);
            else if (key == "--write")
                options.write = argv[i + 1];
            else
                throw std::runtime_error("no option " + key + " (--blocks N, --runs N, --write DIR)");
        }
        moraine::run(options);
        return 0;
    } catch (const std::exception& e) {
        fmt::print(stderr, "benchmark_p2g: {}\n", e.what());
        return 1;
    }
}
