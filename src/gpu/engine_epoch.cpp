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

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::make_tiles(std::size_t tiles) {
    tile_capacity_ = tiles;
    ++layout_;
    ghost_capacity_ = epoch_.ghost.size() + epoch_.ghost.size() / 8;
    tiles_.release(stream_);
    tiles_.resize((tiles + ghost_capacity_) * tile_quads(), stream_);
    lists_.limit_tiles(static_cast<std::uint32_t>(tiles), tables_.view(), stream_);
    if (sleepers_) sleepers_->resize_tiles(tiles + ghost_capacity_, stream_);
    if (method_.grid_bulk()) pressure_.resize(tiles + ghost_capacity_, epoch_.node_key.size(), stream_);
}

/// All that a particle and its part of a block take, and nine tenths of the memory: the rest is the driver's, the
/// transports' and what moves pass through.
template <class Real, int Dim>
std::int64_t DeviceEngine<Real, Dim>::capacity() const {
    if (census_.particles == 0) return this->unlimited;
    const double rows = static_cast<double>(records().bytes() + sizeof(Row<Real>));
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

/// Copies tables during the steps under way, over those of two epochs before: who read them has passed, because what
/// asked for new tables was told by a report of the present ones.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::prepare(const EpochTables<Dim>& tables) {
    check(cudaSetDevice(device_), "Choosing the device");
    next_tables_.upload(tables, upload_);
    next_list_tables_.upload(tables, epoch_.own, upload_);
    if (exchange_) next_routes_.upload(tables, upload_);
    upload_.wait();
    prepared_ = tables.serial;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::take_tables(EpochTables<Dim> tables) {
    if (prepared_ == 0 || prepared_ != tables.serial) prepare(tables);
    epoch_ = std::move(tables);
    tables_.swap(next_tables_);
    lists_.swap(next_list_tables_);
    if (exchange_) exchange_->routes.swap(next_routes_);
    prepared_ = 0;
}

/// What an epoch's tables ask for, once the lists are in place. Tiles have space to spare: a flow that spreads occupies
/// a few blocks more in every epoch.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::open_epoch() {
    ++layout_;
    const std::size_t ghosts = epoch_.ghost.size(), node_blocks = epoch_.node_key.size();
    if (materials_) materials_->open(epoch_.own.size(), exchange_ ? 2 : 1, stream_);
    if (node_blocks > node_of_.size()) {
        const std::size_t most = node_blocks + node_blocks / 4;
        node_of_.resize(most, stream_);
        count_up(static_cast<std::uint32_t>(most), reinterpret_cast<std::uint32_t*>(node_of_.data()), stream_);
    }
    nodes_.resize(node_blocks * static_cast<std::size_t>(2 * Block<Dim>::cells), stream_);
    if (method_.stiffness()) {
        light_marks_.resize(node_blocks * light_marks<Dim>, stream_);
        limited_.resize(epoch_.own.size(), stream_);
        limited_blocks_.resize(2 * LimitedBlocks::lists * epoch_.own.size(), stream_);
    }
    refresh_clock_.fit(static_cast<std::size_t>(census_.particles) * records().bytes(), cache_);
    const auto blocks = static_cast<std::size_t>(census_.blocks);
    const std::size_t least = std::min(epoch_.own.size(), blocks + blocks / 64 + 16);
    const std::size_t capacity = std::min(epoch_.own.size(), blocks + blocks / 12 + 32);
    if (least > tile_capacity_ || 2 * capacity < tile_capacity_ || ghosts > ghost_capacity_) make_tiles(capacity);
    if (method_.grid_bulk()) pressure_.resize(tile_capacity_ + ghost_capacity_, node_blocks, stream_);
    if (sleepers_) sleepers_->open(epoch_.own.size(), ghosts, stream_);
    report_is_of_epoch_ = false;
    gaps_.forget();
    near_blocks_.forget();
    if (exchange_) exchange_->open(epoch_, scene_.structures.size(), stream_);
}

/// What the next report will say of the boundary, for those who need it before.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::count_boundary() {
    if (!exchange_) return;
    count_migration_bound();
    stream_.wait();
    boundary_blocks_ = static_cast<int>(lists_.occupied_boundary());
    const Counters counted = counters_.host().front();
    census_.migration_bound = {counted.migration_bound[0], counted.migration_bound[1]};
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::count_migration_bound() {
    if (!exchange_) return;
    exchange_->migration.count_migration_bound(exchange_->routes.send(), tables_.view(), lists_.view(),
                                               counters_.data(), stream_);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::adopt(EpochTables<Dim> tables, const BinnedBlocks& binned) {
    stream_.wait();
    share_.install(std::move(tables), binned);
    take_tables(share_.tables());
    const std::size_t most = capacity_for(binned.slot.size());
    lists_.install(epoch_, tables_.view(), binned, most);
    particles_.upload(share_.particles.columns(), binned.slot, most);
    begin(binned.slot.size(), binned.key.size(), most);
    share_is_of_now_ = true;
}

/// A rank of several has columns even before it has particles: records are the same on all.
template <class Real, int Dim>
std::size_t DeviceEngine<Real, Dim>::capacity_for(std::size_t particles) const {
    return particles + (exchange_ ? particles / 64 + 64 : 0);
}

/// Particles and their lists are in place: what follows from them.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::begin(std::size_t particles, std::size_t blocks, std::size_t most) {
    bound_cells();
    set_stored(particles);
    census_ = {static_cast<std::int64_t>(particles), static_cast<std::int64_t>(blocks), {}};
    gradient_.resize(kernels_.stress.empty() ? 0 : most * Dim * Dim);
    open_epoch();
    count_boundary();
    find_sleepers();
    stream_.wait();
    refresh_clock_.begin_again();
}

/// While a step is under way its moves are binned by the old tables, and nobody waits.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::renew(EpochTables<Dim> tables) {
    pending_ = std::move(tables);
    if (moving_) return;
    report_lead();
    take_census();
    change_tables();
    count_boundary();
    find_sleepers();
    stream_.wait();  // who reads the lists waits for the last binning alone
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::change_tables() {
    take_tables(std::move(*pending_));
    pending_.reset();
    lists_.renew(epoch_, tables_.view(), stream_);
    open_epoch();
    share_is_of_now_ = false;
}

/// Occupied blocks.
template <class Real, int Dim>
std::vector<ListRange> DeviceEngine<Real, Dim>::ranges() const {
    const std::vector<std::uint32_t> first = lists_.first();
    std::vector<ListRange> all;
    for (std::size_t b = 0; b < epoch_.own.size(); ++b)
        if (first[b + 1] > first[b]) all.push_back({epoch_.own[b], first[b], first[b + 1] - first[b]});
    return all;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::bound_cells() {
    const ListView<Dim> list = lists_.view();
    gpu::bound_cells<Real, Dim>(static_cast<int>(epoch_.own.size()), list.first, list.slot,
                                particles_.view().core[CoreRows<Real, Dim>::place], lists_.cell_bounds(), stream_);
}

/// Blocks keep their lists wherever they go. Incoming particles stand behind all that is stored until memory is next
/// put in order.
template <class Real, int Dim>
BlockMoveCount DeviceEngine<Real, Dim>::repartition(EpochTables<Dim> tables, std::span<const std::int32_t> owner) {
    if (moving_) throw std::logic_error("blocks move in the binned state alone");
    report_lead();
    take_census();
    stream_.wait();
    if (!exchange_) {  // alone: all stays
        install(std::move(tables), ranges());
        return {};
    }
    BlockPlan plan = plan_block_moves(exchange_->comm, ranges(), owner);
    const auto here = static_cast<std::size_t>(census_.particles);
    if (stored_ + plan.incoming > particles_.capacity()) refresh();
    if (here + plan.incoming > particles_.capacity()) refresh_and_grow(here + plan.incoming);
    const auto first_free = static_cast<std::uint32_t>(stored_);
    exchange_->moves.move(plan, lists_.slots(), records(), first_free, stream_);

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
    set_stored(stored_ + plan.incoming);
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
    take_tables(std::move(tables));
    lists_.rearrange(epoch_, tables_.view(), binned, blocks, stream_);
    bound_cells();
    open_epoch();
    find_sleepers();
    stream_.wait();
    count_boundary();
    if (timed_) watch_.begin_again(stream_);
    share_is_of_now_ = false;
}

template <class Real, int Dim>
Patch<Host, Real, Dim>& DeviceEngine<Real, Dim>::share() {
    if (share_is_of_now_) return share_;
    stream_.wait();
    const std::vector<std::uint32_t> first = lists_.first();
    BinnedBlocks binned;
    for (std::size_t b = 0; b < epoch_.own.size(); ++b) {
        if (first[b + 1] == first[b]) continue;
        binned.key.push_back(epoch_.own[b]);
        binned.count.push_back(first[b + 1] - first[b]);
    }
    binned.slot = share_.start_over(first.back());
    particles_.download(share_.particles.columns(), lists_.slots(), first.back());
    share_.install(epoch_, binned);
    share_is_of_now_ = true;
    return share_;
}

template <class Real, int Dim>
BlockCounts DeviceEngine<Real, Dim>::block_counts(bool with_cells) {
    report_lead();
    reported_.wait();  // the lists of the last binning are there, and stay until the next
    const std::vector<std::uint32_t> first = lists_.first(reading_);
    const std::vector<std::uint8_t> asleep = sleepers_ ? sleepers_->binned(reading_) : std::vector<std::uint8_t>{};
    const std::vector<std::uint32_t> cells = with_cells ? lists_.cell_first(reading_) : std::vector<std::uint32_t>{};
    BlockCounts counts;
    for (std::size_t b = 0; b < epoch_.own.size(); ++b) {
        if (first[b + 1] == first[b]) continue;
        counts.key.push_back(epoch_.own[b]);
        counts.count.push_back(first[b + 1] - first[b]);
        if (sleepers_) counts.asleep.push_back(asleep[b]);
        const auto bounds = cells.begin() + static_cast<std::ptrdiff_t>(with_cells ? b * Lists<Dim>::bounds : 0);
        std::int64_t occupied = 0;
        for (int c = 0; with_cells && c < Block<Dim>::cells; ++c) occupied += bounds[c + 1] > bounds[c];
        if (with_cells) counts.cells.push_back(occupied);
    }
    return counts;
}

/// The flow occupies more blocks than there were tiles for: the lists were told to be empty meanwhile.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::grow_tiles() {
    if (exchange_) exchange_->stream.wait();
    stream_.wait();
    PoolArray<Quad<Real>> ghosts;  // those that sleep do not come again
    ghosts.resize(sleepers_ ? epoch_.ghost.size() * tile_quads() : 0, stream_);
    copy_tiles(tiles_, ghosts, ghosts.size(), stream_);
    make_tiles(static_cast<std::size_t>(census_.blocks + census_.blocks / 8));
    copy_tiles(ghosts, tiles_, ghosts.size(), stream_);
    ghosts.release(stream_);
    if (summed_) sum();
}

/// Memory into list order. Between P2G and the gather it disturbs nobody.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::refresh() {
    const auto n = static_cast<std::size_t>(census_.particles);
    if (exchange_) stream_.wait_for(exchange_->boundary_summed);
    particles_.refresh(lists_.slots(), n, stream_);
    count_up(static_cast<std::uint32_t>(n), lists_.slots(), stream_);
    set_stored(n);
    refresh_clock_.begin_again();
}

/// Slots from n on are free.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::set_stored(std::size_t n) {
    count_up(1, &counters_.data()->stored, stream_, static_cast<std::uint32_t>(n));
    stored_ = n;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::refresh_and_grow(std::size_t most) {
    refresh();
    stream_.wait();
    ++layout_;
    most += most / 16;
    particles_.grow(static_cast<std::size_t>(census_.particles), most);
    lists_.grow(most);
    gradient_.resize(kernels_.stress.empty() ? 0 : most * Dim * Dim);
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
