#include "replay/halo_forecast.hpp"

#include <algorithm>
#include <unordered_map>

#include "core/data/block.hpp"

namespace moraine {
namespace {

constexpr std::size_t most_in_table = 2000000;  // blocks: 216 MB; beyond, neighbours are looked up each time
constexpr std::int32_t empty = -2;              // in the table while the apron has no numbers

/// Nodes of a tile that blocks at the offsets of `mask` share with it.
template <int Dim>
std::int64_t nodes_of(std::uint32_t mask, int width) {
    const int side = tile_side(width);
    std::int64_t nodes = 0;
    for (int n = 0; n < power<Dim>(side); ++n) {
        const int at[3] = {n % side, n / side % side, n / (side * side)};
        bool any = false;
        for (int code = 0; code < Block<Dim>::offsets && !any; ++code) {
            if (!(mask >> code & 1u)) continue;
            any = true;
            for (int a = 0; a < Dim; ++a) {
                const int eta = Block<Dim>::offset(code, a);
                any = any && (eta == 0 || (eta > 0 ? at[a] >= 4 : at[a] < width - 1));
            }
        }
        nodes += any;
    }
    return nodes;
}

/// Bytes of a tile's message by the offsets that need it.
class TileBytes {
  public:
    TileBytes(const Layout& layout, int node_bytes) : layout_(layout), node_bytes_(node_bytes) {}

    std::int64_t operator()(std::uint32_t mask) {
        auto [it, fresh] = known_.try_emplace(mask, 0);
        if (fresh) {
            const bool flat = layout_.dimensions == 2;
            const std::int64_t nodes = flat ? nodes_of<2>(mask, layout_.width) : nodes_of<3>(mask, layout_.width);
            it->second = 1 + nodes * node_bytes_;
        }
        return it->second;
    }

  private:
    const Layout& layout_;
    int node_bytes_;
    std::unordered_map<std::uint32_t, std::int64_t> known_;
};

bool is_face(const Layout& layout, int code) {
    int apart = 0;
    for (int a = 0; a < layout.dimensions; ++a) apart += Block<3>::offset(code, a) != 0;
    return apart == 1;
}

/// The ranks that need one tile, and by which offsets.
struct Readers {
    std::int32_t rank[27];
    std::uint32_t mask[27];
    int count = 0;

    void add(std::int32_t reader, int code) {
        int k = 0;
        while (k < count && rank[k] != reader) ++k;
        if (k == count) rank[count] = reader, mask[count++] = 0;
        mask[k] |= 1u << code;
    }
};

/// A tile of so many bytes.
void add_sent(std::span<const std::int32_t> hosts, std::int32_t from, std::int32_t to, std::int64_t bytes,
              HaloForecast& halo) {
    const bool within = hosts[from] == hosts[to];
    (within ? halo.sent[from].bytes_within : halo.sent[from].bytes_between) += bytes;
    halo.tiles_between += !within;
}

void count_neighbours(std::vector<std::uint64_t>& pairs, int ranks, std::span<const std::int32_t> hosts,
                      HaloForecast& halo) {
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    halo.neighbours_mean = static_cast<double>(pairs.size()) / ranks;
    for (std::size_t first = 0, k = 0; k < pairs.size(); ++k) {
        if (pairs[k] >> 32 != pairs[first] >> 32) first = k;
        halo.neighbours_max = std::max(halo.neighbours_max, static_cast<std::int32_t>(k - first + 1));
        if (hosts.empty()) continue;
        const std::uint64_t from = pairs[k] >> 32, to = pairs[k] & 0xffffffffu;
        ++(hosts[from] == hosts[to] ? halo.sent[from].neighbours_within : halo.sent[from].neighbours_between);
    }
}

}  // namespace

HaloSurroundings::HaloSurroundings(const Layout& layout, std::span<const BlockLoad> blocks)
    : layout_(layout), blocks_(blocks), offsets_(static_cast<std::size_t>(offsets_of(layout))) {
    occupied_ = BlockIndex<3>(keys_of(blocks));
    if (blocks.size() <= most_in_table) table_.assign(blocks.size() * offsets_, -1);
    find_apron();
    for (std::size_t i = 0; i < table_.size(); ++i)
        if (table_[i] == empty) table_[i] = look_up(blocks[i / offsets_].key, static_cast<int>(i % offsets_));
}

/// Enters the occupied neighbours of a block into the table, and the empty ones into the apron.
void HaloSurroundings::look_around(std::size_t b) {
    Key near = 0;
    for (int code = 0; code < offsets_of(layout_); ++code) {
        if (!neighbour_key(layout_, blocks_[b].key, code, near)) continue;
        const std::int32_t here = occupied_.find(near);
        if (!table_.empty()) table_[b * offsets_ + static_cast<std::size_t>(code)] = here < 0 ? empty : here;
        if (here < 0) apron_.push_back(near);
    }
}

void HaloSurroundings::find_apron() {
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        look_around(b);
        if (apron_.size() < (std::size_t(1) << 22) && b + 1 < blocks_.size()) continue;
        std::sort(apron_.begin(), apron_.end());  // now and then, so that the list stays short
        apron_.erase(std::unique(apron_.begin(), apron_.end()), apron_.end());
    }
    empty_ = BlockIndex<3>(apron_);
    Key near = 0;
    for (const Key key : apron_) {
        std::int32_t inherits_from = -1;
        for (int code = 0; inherits_from < 0 && code < offsets_of(layout_); ++code)
            if (neighbour_key(layout_, key, code, near)) inherits_from = occupied_.find(near);
        inherits_from_.push_back(inherits_from);
    }
}

std::int32_t HaloSurroundings::look_up(Key key, int code) const {
    Key near = 0;
    if (!neighbour_key(layout_, key, code, near)) return -1;
    const std::int32_t here = occupied_.find(near);
    if (here >= 0) return here;
    const std::int32_t there = empty_.find(near);
    return there < 0 ? -1 : static_cast<std::int32_t>(blocks_.size()) + there;
}

std::vector<std::int32_t> HaloSurroundings::owners_of_apron(std::span<const std::int32_t> owners,
                                                            const Partitioner& partitioner) const {
    std::vector<std::int32_t> empty_owner;
    empty_owner.reserve(apron_.size());
    for (std::size_t e = 0; e < apron_.size(); ++e) {
        const std::int32_t rank = partitioner.owner_at(block_position(layout_, apron_[e]));
        empty_owner.push_back(rank >= 0 ? rank : owners[inherits_from_[e]]);
    }
    return empty_owner;
}

HaloForecast HaloSurroundings::halo(std::span<const std::int32_t> owners, const Partitioner& partitioner, int ranks,
                                    int node_bytes, std::span<const std::int32_t> hosts) const {
    const std::vector<std::int32_t> empty_owner = owners_of_apron(owners, partitioner);
    HaloForecast halo;
    if (!hosts.empty()) halo.sent.resize(static_cast<std::size_t>(ranks));
    TileBytes bytes_of(layout_, node_bytes);
    std::vector<std::int64_t> sent(static_cast<std::size_t>(ranks), 0);
    std::vector<std::uint64_t> pairs;
    const auto n = static_cast<std::int32_t>(blocks_.size());
    for (std::int32_t b = 0; b < n; ++b) {
        Readers readers;
        for (int code = 0; code < static_cast<int>(offsets_); ++code) {
            const std::int32_t near = at(b, code);
            if (near < 0) continue;
            const std::int32_t rank = near < n ? owners[near] : empty_owner[near - n];
            if (rank == owners[b]) continue;
            readers.add(rank, code);
            halo.face_cut += near < n && near > b && is_face(layout_, code);
        }
        for (int k = 0; k < readers.count; ++k) {
            ++halo.tiles;
            const std::int64_t bytes = bytes_of(readers.mask[k]);
            sent[owners[b]] += bytes;
            if (!hosts.empty()) add_sent(hosts, owners[b], readers.rank[k], bytes, halo);
            const std::uint64_t pair =
                static_cast<std::uint64_t>(owners[b]) << 32 | static_cast<std::uint32_t>(readers.rank[k]);
            if (pairs.empty() || pairs.back() != pair) pairs.push_back(pair);
        }
    }
    for (const std::int64_t bytes : sent) halo.bytes += bytes, halo.busiest_bytes = std::max(halo.busiest_bytes, bytes);
    count_neighbours(pairs, ranks, hosts, halo);
    return halo;
}

}  // namespace moraine
