#include "blocks/next_epoch.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>

#include "blocks/key_order.hpp"

namespace moraine {

namespace {

/// Threads of asynchronous work: one makes 5000 blocks in a millisecond, and an epoch lasts for many. More than are
/// needed take cores from those that launch the steps.
int async_threads(std::size_t blocks) {
    return std::clamp(static_cast<int>(blocks / 8192), 1, std::min(8, omp_get_max_threads()));
}

bool before(const OccupiedBlock& a, const OccupiedBlock& b) {
    return a.key < b.key;
}

/// A thread of its own does it, or did.
template <class T>
bool is_running(const std::future<T>& work) {
    return work.valid() && work.wait_for(std::chrono::seconds(0)) != std::future_status::deferred;
}

std::vector<OccupiedBlock> blocks_of(const std::vector<Key>& keys, const std::vector<std::int64_t>& counts) {
    std::vector<OccupiedBlock> blocks;
    blocks.reserve(keys.size());
    std::size_t at = 0;
    for (std::size_t rank = 0; rank < counts.size(); ++rank)
        for (std::int64_t i = 0; i < counts[rank]; ++i) blocks.push_back({keys[at++], static_cast<std::int32_t>(rank)});
    return in_key_order(blocks, counts);
}

}  // namespace

template <int Dim>
EpochTables<Dim> NextEpoch<Dim>::make(std::vector<OccupiedBlock> occupied) {
    if (made_.valid()) made_.get();
    topology_ = make_topology<Dim>(domain_, occupied, owner_at_);
    occupied_ = std::move(occupied);
    EpochTables<Dim> tables = make_epoch<Dim>(topology_, domain_, stencil_, rank_);
    tables.serial = ++made_so_far_;
    return tables;
}

template <int Dim>
typename NextEpoch<Dim>::Made NextEpoch<Dim>::made_of(std::vector<OccupiedBlock> occupied, bool stays,
                                                      std::int64_t serial) const {
    if (!stays && occupied.empty()) return {};
    if (stays && std::includes(occupied_.begin(), occupied_.end(), occupied.begin(), occupied.end(), before)) return {};
    Made made;
    made.topology = make_topology<Dim>(domain_, occupied, owner_at_, stays ? &topology_ : nullptr);
    made.tables = make_epoch<Dim>(made.topology, domain_, stencil_, rank_);
    made.tables->serial = serial;
    made.occupied = std::move(occupied);
    if (prepare_) prepare_(*made.tables);
    return made;
}

template <int Dim>
template <class Blocks>
void NextEpoch<Dim>::launch(bool async, bool stays, std::size_t count, Blocks blocks) {
    const int threads = async_threads(count);
    const std::int64_t serial = ++made_so_far_;
    made_ = std::async(
        async ? std::launch::async : std::launch::deferred,
        [this, async, stays, threads, serial, blocks = std::move(blocks), forgotten = std::move(made_)]() mutable {
            if (is_running(forgotten)) forgotten.wait();  // prepare_() is of one thread at a time
            if (async) omp_set_num_threads(threads);      // of this thread
            return made_of(blocks(), stays, serial);
        });
}

template <int Dim>
void NextEpoch<Dim>::start(std::vector<Key> keys, std::vector<std::int64_t> counts, bool async) {
    const std::size_t count = keys.size();
    launch(async, true, count,
           [keys = std::move(keys), counts = std::move(counts)] { return blocks_of(keys, counts); });
}

template <int Dim>
void NextEpoch<Dim>::start_repartition(std::size_t count, std::function<std::vector<OccupiedBlock>()> occupied,
                                       bool async) {
    launch(async, false, count, std::move(occupied));
}

template <int Dim>
bool NextEpoch<Dim>::is_ready() const {
    return !made_.valid() || made_.wait_for(std::chrono::seconds(0)) != std::future_status::timeout;
}

template <int Dim>
void NextEpoch<Dim>::wait() const {
    if (!is_ready()) made_.wait();
}

template <int Dim>
std::optional<EpochTables<Dim>> NextEpoch<Dim>::take() {
    Made made = made_.get();
    if (!made.tables) return {};
    occupied_ = std::move(made.occupied);
    topology_ = std::move(made.topology);
    return std::move(made.tables);
}

template <int Dim>
std::int32_t NextEpoch<Dim>::owner_near(Key key) const {
    if (const std::int64_t at = topology_.find(key); at >= 0) return topology_.owner[static_cast<std::size_t>(at)];
    const std::int32_t asked = owner_at_ ? owner_at_(Morton<Dim>::decode(key)) : -1;
    if (asked >= 0 || topology_.keys.empty()) return std::max(asked, 0);
    const auto above = std::lower_bound(topology_.keys.begin(), topology_.keys.end(), key);
    const auto before = std::max<std::ptrdiff_t>(above - topology_.keys.begin() - 1, 0);
    return topology_.owner[static_cast<std::size_t>(before)];
}

template <int Dim>
std::vector<std::int32_t> NextEpoch<Dim>::owners_of(const std::vector<Key>& keys) const {
    std::vector<std::int32_t> owners;
    owners.reserve(keys.size());
    auto at = topology_.keys.begin();
    for (Key key : keys) {
        at = std::find(at, topology_.keys.end(), key);
        owners.push_back(topology_.owner[static_cast<std::size_t>(at - topology_.keys.begin())]);
    }
    return owners;
}

template class NextEpoch<2>;
template class NextEpoch<3>;

}  // namespace moraine
