// The engine's share without the memory of the host: particles that begin on the device, and are looked at in pieces.

#include "gpu/engine.hpp"
#include "gpu/memory/lattice_seeding.hpp"

namespace moraine::gpu {

/// Particles of a piece: some 80 to 200 MB on the host.
constexpr std::uint32_t piece_particles = 1 << 20;

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::adopt(EpochTables<Dim> tables, const LatticeTables<Real, Dim>& lattice) {
    stream_.wait();
    take_tables(std::move(tables));
    BinnedBlocks binned;  // slots are 0, 1, ...: nobody lists them
    std::size_t n = 0;
    for (std::size_t b = 0; b < epoch_.own.size(); ++b) {
        const std::uint32_t count = lattice.view().count(epoch_.position[b]);
        if (count == 0) continue;
        binned.key.push_back(epoch_.own[b]);
        binned.count.push_back(count);
        n += count;
    }
    const std::size_t most = capacity_for(n);
    lists_.install(epoch_, tables_.view(), binned, most);
    particles_.clear(most);
    const DeviceLattice<Real, Dim> there(lattice);
    seed_blocks(tables_.view().own, there.view(), tables_.view().position, lists_.view().first, particles_.view(),
                stream_);
    begin(n, binned.key.size(), most);
    share_is_of_now_ = false;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::each_piece(const PieceReader& f, const std::vector<std::string>& only) {
    if (share_is_of_now_) return f(whole_of(share_, only));
    stream_.wait();
    const std::vector<std::uint32_t> first = lists_.first();
    const int own = static_cast<int>(epoch_.own.size());
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
        particles_.download(columns, lists_.slots() + start(begin), n);
        f(SharePiece<Real, Dim>{epoch_, begin, end, first.data(), slots.data(), rows.view(), columns});
    }
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
