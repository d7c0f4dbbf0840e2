#include "gpu/epoch_state.hpp"

#include <algorithm>

#include "gpu/memory/refresh.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
EpochState<Real, Dim>::EpochState(int stencil_width, bool several_ranks)
    : width(stencil_width), several(several_ranks) {
    check(cudaGetDevice(&device), "Asking for the device");
}

template <class Real, int Dim>
void EpochState<Real, Dim>::prepare(const EpochTables<Dim>& next) {
    check(cudaSetDevice(device), "Choosing the device");
    next_table.upload(next, upload);
    next_list_tables.upload(next, tables.own, upload);
    if (several) next_routes.upload(next, upload);
    upload.wait();
    prepared = next.serial;
}

template <class Real, int Dim>
void EpochState<Real, Dim>::take(EpochTables<Dim> next, Exchange<Real, Dim>* exchange) {
    if (prepared == 0 || prepared != next.serial) prepare(next);
    tables = std::move(next);
    table.swap(next_table);
    lists.swap(next_list_tables);
    if (exchange) exchange->routes.swap(next_routes);
    prepared = 0;
}

template <class Real, int Dim>
void EpochState<Real, Dim>::make_tiles(std::size_t count, cudaStream_t stream) {
    tile_capacity = count;
    ++layout;
    ghost_capacity = tables.ghost.size() + tables.ghost.size() / 8;
    tiles.release(stream);
    tiles.resize((count + ghost_capacity) * tile_quads(), stream);
    lists.limit_tiles(static_cast<std::uint32_t>(count), table.view(), stream);
}

template <class Real, int Dim>
void EpochState<Real, Dim>::make_nodes(cudaStream_t stream) {
    const std::size_t blocks = tables.node_key.size();
    if (blocks > node_of.size()) {
        const std::size_t most = blocks + blocks / 4;
        node_of.resize(most, stream);
        count_up(static_cast<std::uint32_t>(most), reinterpret_cast<std::uint32_t*>(node_of.data()), stream);
    }
    nodes.resize(blocks * static_cast<std::size_t>(2 * Block<Dim>::cells), stream);
}

template <class Real, int Dim>
std::size_t EpochState<Real, Dim>::tiles_for(std::size_t blocks) const {
    return std::min(own(), blocks + blocks / 12 + 32);
}

template <class Real, int Dim>
bool EpochState<Real, Dim>::wants_tiles(std::size_t blocks) const {
    const std::size_t least = std::min(own(), blocks + blocks / 64 + 16);
    return least > tile_capacity || 2 * tiles_for(blocks) < tile_capacity || tables.ghost.size() > ghost_capacity;
}

template <class Real, int Dim>
std::vector<ListRange> EpochState<Real, Dim>::occupied() const {
    const std::vector<std::uint32_t> first = lists.first();
    std::vector<ListRange> all;
    for (std::size_t b = 0; b < own(); ++b)
        if (first[b + 1] > first[b]) all.push_back({tables.own[b], first[b], first[b + 1] - first[b]});
    return all;
}

template struct EpochState<float, 2>;
template struct EpochState<float, 3>;
template struct EpochState<double, 2>;
template struct EpochState<double, 3>;

}  // namespace moraine::gpu
