// The engine between steps: epochs, capacity, and whole blocks.

#include <algorithm>
#include <stdexcept>

#include "gpu/engine.hpp"
#include "gpu/memory/refresh.hpp"

namespace moraine::gpu {

namespace {

template <class T>
void copy_tiles(const PoolArray<T>& from, const PoolArray<T>& to, std::size_t n, cudaStream_t stream) {
    if (n > 0)
        check(cudaMemcpyAsync(to.data(), from.data(), n * sizeof(T), cudaMemcpyDeviceToDevice, stream),
              "Copying tiles");
}

}  // namespace

/// In the epoch's tables of now.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::make_tiles(std::size_t tiles) {
    epoch_.make_tiles(tiles, stream_);
    if (sleepers_) sleepers_->resize_tiles(tiles + epoch_.ghost_capacity, stream_);
    if (method_.grid_bulk())
        fluid_.pressure.resize(tiles + epoch_.ghost_capacity, epoch_.tables.node_key.size(), stream_);
}

/// All that a particle and its part of a block take, and nine tenths of the memory: the rest is the driver's, the
/// transports' and what moves pass through.
template <class Real, int Dim>
std::int64_t DeviceEngine<Real, Dim>::capacity() const {
    if (census_.particles == 0) return unlimited_particles;
    const double rows = static_cast<double>(store_.records().bytes() + sizeof(Row<Real>));
    const double lists = 2 * 4 + 2 + 0.125 + 5 + (kernels_.stress.empty() ? 0 : Dim * Dim * sizeof(Real));
    double block =
        sizeof(Real) * node_reals * (power<Dim>(tile_side(method_.stencil.width)) + 1.3 * Block<Dim>::cells) +
        4.0 * (Lists<Dim>::bounds + outgoing_bounds<Dim> + 2 * Block<Dim>::offsets);
    if (method_.grid_bulk()) block += pressure_bytes<Real, Dim>();
    if (materials_) block += 4.0 * (exchange_ ? 2 : 1) * static_cast<double>(kernels_.stress.size() + 1) + 2;
    const double each =
        rows + lists + block * static_cast<double>(census_.blocks) / static_cast<double>(census_.particles);
    return static_cast<std::int64_t>(0.9 * static_cast<double>(memory_) / each);
}

/// Memory by an epoch's tables, once the lists are in place.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::open_epoch() {
    ++epoch_.layout;
    const std::size_t own = epoch_.own(), node_blocks = epoch_.tables.node_key.size();
    if (materials_) materials_->open(own, exchange_ ? 2 : 1, stream_);
    epoch_.make_nodes(stream_);
    light_.open(node_blocks, own, stream_);
    if (added_.loads) added_.loads->open(own, stream_);
    store_.open(census_.particles);
    const auto blocks = static_cast<std::size_t>(census_.blocks);
    if (epoch_.wants_tiles(blocks)) make_tiles(epoch_.tiles_for(blocks));
    if (method_.grid_bulk()) fluid_.pressure.resize(epoch_.tile_capacity + epoch_.ghost_capacity, node_blocks, stream_);
    if (sleepers_) sleepers_->open(own, epoch_.tables.ghost.size(), stream_);
    reports_.is_of_epoch = false;
    contact_.forget();
    if (surfaces_) surfaces_->forget();
    if (added_.ends) added_.ends->forget();
    if (exchange_) exchange_->open(epoch_.tables, scene_.structures.size(), stream_);
}

/// Sizes of the boundary, which kernels need before the next report has them.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::count_boundary() {
    if (!exchange_) return;
    count_migration_bound();
    stream_.wait();
    boundary_blocks_ = static_cast<int>(epoch_.lists.occupied_boundary());
    const Counters counted = reports_.counters.host().front();
    census_.migration_bound = {counted.migration_bound[0], counted.migration_bound[1]};
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::count_migration_bound() {
    if (!exchange_) return;
    exchange_->migration.count_migration_bound(exchange_->routes.send(), epoch_.table.view(), epoch_.lists.view(),
                                               reports_.counters.data(), stream_);
}

template <class Real, int Dim>
BlockMoveCount DeviceEngine<Real, Dim>::begin(EpochTables<Dim> tables, const HostShare& share) {
    const BinnedBlocks& binned = share.binned;
    stream_.wait();
    share_.install(std::move(tables), binned);
    epoch_.take(share_.tables(), exchange_.get());
    const std::size_t most = capacity_for(binned.slot.size());
    epoch_.lists.install(epoch_.tables, epoch_.table.view(), binned, most);
    store_.rows.upload(share_.particles.columns(), binned.slot, most);
    begin_with(binned.slot.size(), binned.key.size(), most);
    share_is_of_now_ = true;
    return {};
}

/// A rank of several has columns even before it has particles: records are the same on all.
template <class Real, int Dim>
std::size_t DeviceEngine<Real, Dim>::capacity_for(std::size_t particles) const {
    return particles + (exchange_ ? particles / 64 + 64 : 0);
}

/// Particles and their lists are in place: what follows from them.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::begin_with(std::size_t particles, std::size_t blocks, std::size_t most) {
    bound_cells();
    set_stored(particles);
    census_ = {static_cast<std::int64_t>(particles), static_cast<std::int64_t>(blocks), {}};
    store_.gradient.resize(kernels_.stress.empty() ? 0 : most * Dim * Dim);
    open_epoch();
    count_boundary();
    find_sleepers();
    stream_.wait();
    store_.clock.begin_again();
}

/// During a step its moves are binned by the old tables first, and the host does not wait.
template <class Real, int Dim>
BlockMoveCount DeviceEngine<Real, Dim>::begin(EpochTables<Dim> tables, const KeptBlocks&) {
    epoch_.pending = std::move(tables);
    if (moving_) return {};
    report_lead();
    take_census();
    change_tables();
    count_boundary();
    find_sleepers();
    stream_.wait();  // block_counts() waits for the last binning alone
    return {};
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::change_tables() {
    epoch_.take(std::move(*epoch_.pending), exchange_.get());
    epoch_.pending.reset();
    epoch_.lists.renew(epoch_.tables, epoch_.table.view(), stream_);
    open_epoch();
    share_is_of_now_ = false;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::bound_cells() {
    const ListView<Dim> list = epoch_.lists.view();
    gpu::bound_cells<Real, Dim>(static_cast<int>(epoch_.tables.own.size()), list.first, list.slot,
                                store_.rows.view().core[CoreRows<Real, Dim>::place], epoch_.lists.cell_bounds(),
                                stream_);
}

/// Blocks keep their lists wherever they go. Incoming particles stand behind all that is stored until memory is next
/// put in order.
template <class Real, int Dim>
BlockMoveCount DeviceEngine<Real, Dim>::begin(EpochTables<Dim> tables, const MovedBlocks& travelling) {
    if (moving_) throw std::logic_error("blocks move in the binned state alone");
    report_lead();
    take_census();
    stream_.wait();
    if (!exchange_) {  // alone: all stays
        install(std::move(tables), epoch_.occupied());
        return {};
    }
    BlockPlan plan = plan_block_moves(exchange_->comm, epoch_.occupied(), travelling.owner);
    const auto here = static_cast<std::size_t>(census_.particles);
    if (store_.used + plan.incoming > store_.rows.capacity()) refresh();
    if (here + plan.incoming > store_.rows.capacity()) refresh_and_grow(here + plan.incoming);
    const auto first_free = static_cast<std::uint32_t>(store_.used);
    exchange_->moves.move(plan, epoch_.lists.slots(), store_.records(), first_free, stream_);

    BlockMoveCount moved;
    std::vector<ListRange> next = std::move(plan.kept);
    for (const BlockPlan::Partner& p : plan.partners) {
        moved.particles += static_cast<std::int64_t>(p.out);
        moved.blocks += static_cast<std::int64_t>(p.leaving.size());
        const auto kept = static_cast<std::ptrdiff_t>(next.size());
        for (const ListRange& s : p.coming) next.push_back({s.key, first_free + s.start, s.count, true});
        std::inplace_merge(next.begin(), next.begin() + kept, next.end(),
                           [](const ListRange& a, const ListRange& b) { return a.key < b.key; });
    }
    set_stored(store_.used + plan.incoming);
    install(std::move(tables), next);
    return moved;
}

/// Begins an epoch with these blocks.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::install(EpochTables<Dim> tables, const std::vector<ListRange>& blocks) {
    BinnedBlocks binned;
    census_ = {0, static_cast<std::int64_t>(blocks.size()), {}};
    for (const ListRange& s : blocks) {
        binned.key.push_back(s.key);
        binned.count.push_back(s.count);
        census_.particles += s.count;
    }
    epoch_.take(std::move(tables), exchange_.get());
    epoch_.lists.rearrange(epoch_.tables, epoch_.table.view(), binned, blocks, stream_);
    bound_cells();
    open_epoch();
    find_sleepers();
    stream_.wait();
    count_boundary();
    if (reports_.timed) reports_.watch.begin_again(stream_);
    share_is_of_now_ = false;
}

template <class Real, int Dim>
Patch<Host, Real, Dim>& DeviceEngine<Real, Dim>::share() {
    if (share_is_of_now_) return share_;
    stream_.wait();
    const std::vector<std::uint32_t> first = epoch_.lists.first();
    BinnedBlocks binned;
    for (std::size_t b = 0; b < epoch_.tables.own.size(); ++b) {
        if (first[b + 1] == first[b]) continue;
        binned.key.push_back(epoch_.tables.own[b]);
        binned.count.push_back(first[b + 1] - first[b]);
    }
    binned.slot = share_.start_over(first.back());
    store_.rows.download(share_.particles.columns(), epoch_.lists.slots(), first.back());
    share_.install(epoch_.tables, binned);
    share_is_of_now_ = true;
    return share_;
}

template <class Real, int Dim>
BlockCounts DeviceEngine<Real, Dim>::block_counts(bool with_cells) {
    report_lead();
    reports_.reported.wait();  // the lists of the last binning are there, and stay until the next
    const std::vector<std::uint32_t> first = epoch_.lists.first(reading_);
    const std::vector<std::uint8_t> asleep = sleepers_ ? sleepers_->binned(reading_) : std::vector<std::uint8_t>{};
    const std::vector<std::uint32_t> cells =
        with_cells ? epoch_.lists.cell_first(reading_) : std::vector<std::uint32_t>{};
    BlockCounts counts;
    counts.capacity = capacity();
    for (std::size_t b = 0; b < epoch_.tables.own.size(); ++b) {
        if (first[b + 1] == first[b]) continue;
        counts.key.push_back(epoch_.tables.own[b]);
        counts.count.push_back(first[b + 1] - first[b]);
        if (sleepers_) counts.asleep.push_back(asleep[b]);
        const auto bounds = cells.begin() + static_cast<std::ptrdiff_t>(with_cells ? b * Lists<Dim>::bounds : 0);
        std::int64_t occupied = 0;
        for (int c = 0; with_cells && c < Block<Dim>::cells; ++c) occupied += bounds[c + 1] > bounds[c];
        if (with_cells) counts.cells.push_back(occupied);
    }
    return counts;
}

/// The flow occupies more blocks than there were tiles for: the lists of blocks were empty meanwhile, so that P2G wrote
/// nothing, and is queued again.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::grow_tiles() {
    if (exchange_) exchange_->stream.wait();
    stream_.wait();
    PoolArray<Quad<Real>> ghosts;  // those that sleep do not come again
    ghosts.resize(sleepers_ ? epoch_.tables.ghost.size() * epoch_.tile_quads() : 0, stream_);
    copy_tiles(epoch_.tiles, ghosts, ghosts.size(), stream_);
    make_tiles(static_cast<std::size_t>(census_.blocks + census_.blocks / 8));
    copy_tiles(ghosts, epoch_.tiles, ghosts.size(), stream_);
    ghosts.release(stream_);
    if (summed_) queue_sums();
}

/// Puts memory into list order. Between P2G and the gather no kernel holds slots.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::refresh() {
    const auto n = static_cast<std::size_t>(census_.particles);
    if (exchange_) stream_.wait_for(exchange_->boundary_summed);
    store_.rows.refresh(epoch_.lists.slots(), n, stream_);
    count_up(static_cast<std::uint32_t>(n), epoch_.lists.slots(), stream_);
    set_stored(n);
    store_.clock.begin_again();
}

/// Slots from n on are free.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::set_stored(std::size_t n) {
    count_up(1, &reports_.counters.data()->stored, stream_, static_cast<std::uint32_t>(n));
    store_.used = n;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::refresh_and_grow(std::size_t most) {
    refresh();
    stream_.wait();
    ++epoch_.layout;
    most += most / 16;
    store_.rows.grow(static_cast<std::size_t>(census_.particles), most);
    epoch_.lists.grow(most);
    store_.gradient.resize(kernels_.stress.empty() ? 0 : most * Dim * Dim);
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
