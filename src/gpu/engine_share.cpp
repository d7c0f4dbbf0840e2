// The engine's share without the memory of the host: particles that are made on the device, and are read in pieces.

#include "gpu/engine.hpp"
#include "gpu/memory/lattice_seeding.hpp"

namespace moraine::gpu {

/// Particles of a piece: some 80 to 200 MB on the host.
constexpr std::uint32_t piece_particles = 1 << 20;

template <class Real, int Dim>
BlockMoveCount DeviceEngine<Real, Dim>::begin(EpochTables<Dim> tables, const LatticeShare<Real, Dim>& share) {
    const LatticeTables<Real, Dim>& lattice = share.lattice;
    stream_.wait();
    epoch_.take(std::move(tables), exchange_.get());
    BinnedBlocks binned;  // slots are 0, 1, ...: no list of them is needed
    std::size_t n = 0;
    for (std::size_t b = 0; b < epoch_.tables.own.size(); ++b) {
        const std::uint32_t count = lattice.view().count(epoch_.tables.position[b]);
        if (count == 0) continue;
        binned.key.push_back(epoch_.tables.own[b]);
        binned.count.push_back(count);
        n += count;
    }
    const std::size_t most = capacity_for(n);
    epoch_.lists.install(epoch_.tables, epoch_.table.view(), binned, most);
    store_.rows.clear(most);
    const DeviceLattice<Real, Dim> there(lattice);
    seed_blocks(epoch_.table.view().own, there.view(), epoch_.table.view().position, epoch_.lists.view().first,
                store_.rows.view(), stream_);
    begin_with(n, binned.key.size(), most);
    share_is_of_now_ = false;
    return {};
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::each_piece(const PieceReader& f, const std::vector<std::string>& only) {
    if (share_is_of_now_) return f(whole_of(share_, only));
    stream_.wait();
    const std::vector<std::uint32_t> first = epoch_.lists.first();
    const int own = static_cast<int>(epoch_.tables.own.size());
    Particles<Host, Real, Dim> rows(method_.needs);
    std::vector<std::uint32_t> slots;
    const auto start = [&](int b) { return first[static_cast<std::size_t>(b)]; };
    for (int begin = 0, end = 0; begin < own; begin = end) {
        do ++end;
        while (end < own && start(end + 1) - start(begin) <= piece_particles);
        const std::size_t n = start(end) - start(begin);
        if (n == 0) continue;
        rows.resize(n);
        while (slots.size() < n) slots.push_back(static_cast<std::uint32_t>(slots.size()));
        const std::vector<ColumnBytes> columns = named(rows.columns(), only);
        store_.rows.download(columns, epoch_.lists.slots() + start(begin), n);
        f(SharePiece<Real, Dim>{epoch_.tables, begin, end, first.data(), slots.data(), rows.view(), columns});
    }
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
