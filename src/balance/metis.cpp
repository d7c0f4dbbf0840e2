#include "balance/metis.hpp"

#include <metis.h>

#include <algorithm>
#include <csignal>
#include <numeric>
#include <string>

#include "balance/block_graph.hpp"
#include "core/data/error.hpp"

namespace moraine {
namespace {

static_assert(sizeof(idx_t) == sizeof(std::int32_t), "the graph is handed over as it is");

constexpr int balance_to = 10;  // [1/1000] above the mean
constexpr int seed = 1;

/// Holds back SIGTERM from this thread and restores what the program does on SIGTERM and SIGABRT: METIS jumps out of
/// its work on either, and puts handlers back as such that serve only once.
class Signals {
  public:
    Signals() {
        sigaction(SIGTERM, nullptr, &term_);
        sigaction(SIGABRT, nullptr, &abort_);
        sigset_t held;
        sigemptyset(&held);
        sigaddset(&held, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &held, &mask_);
    }
    ~Signals() {
        sigaction(SIGTERM, &term_, nullptr);
        sigaction(SIGABRT, &abort_, nullptr);
        pthread_sigmask(SIG_SETMASK, &mask_, nullptr);
    }
    Signals(const Signals&) = delete;
    Signals& operator=(const Signals&) = delete;

  private:
    struct sigaction term_, abort_;
    sigset_t mask_;
};

}  // namespace

bool metis_is_built() {
    return true;
}

std::vector<std::int32_t> metis_parts(const Layout& layout, std::span<const BlockLoad> blocks, int parts) {
    BlockGraph graph = graph_of(layout, blocks);
    refuse_metis_graph(graph.first.back(), std::accumulate(graph.shared.begin(), graph.shared.end(), std::int64_t(0)));
    std::vector<std::int32_t> first(graph.first.begin(), graph.first.end());
    std::vector<std::int32_t> loads = metis_loads(blocks);
    std::vector<std::int32_t> part(blocks.size(), 0);

    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = seed;
    options[METIS_OPTION_UFACTOR] = balance_to;
    idx_t vertices = static_cast<idx_t>(blocks.size());
    idx_t constraints = 1;
    idx_t wanted = parts;
    idx_t cut = 0;
    const Signals signals;
    const int result =
        METIS_PartGraphKway(&vertices, &constraints, first.data(), graph.neighbour.data(), loads.data(), nullptr,
                            graph.shared.data(), &wanted, nullptr, nullptr, options, &cut, part.data());
    if (result == METIS_ERROR_MEMORY)
        throw MachineError("METIS ran out of memory (" + std::to_string(blocks.size()) +
                           " blocks). Use balance.partitioner = \"hilbert\"?");
    if (result != METIS_OK)
        throw MachineError("METIS failed (code " + std::to_string(result) +
                           "). Use balance.partitioner = \"hilbert\"?");
    return part;
}

std::vector<std::int32_t> metis_loads(std::span<const BlockLoad> blocks) {
    constexpr std::int64_t most = std::int64_t(1) << 30;
    std::int64_t total = 0;
    for (const BlockLoad& block : blocks) total += block.weight;
    // half of the sum is left for the blocks that are rounded up to 1
    const double scale = total > most ? static_cast<double>(most) / 2 / static_cast<double>(total) : 1;
    std::vector<std::int32_t> loads;
    loads.reserve(blocks.size());
    for (const BlockLoad& block : blocks) {
        const auto scaled = static_cast<std::int32_t>(scale * static_cast<double>(block.weight));
        loads.push_back(std::max(scaled, block.weight > 0 ? 1 : 0));
    }
    return loads;
}

void refuse_metis_graph(std::int64_t entries, std::int64_t shared) {
    if (entries <= INT32_MAX && shared <= INT32_MAX) return;
    throw InputError("balance.partitioner = \"metis\" (its 32 bits cannot count " + std::to_string(entries) +
                     " neighbours that share " + std::to_string(shared) + " nodes). Use hilbert?");
}

}  // namespace moraine
