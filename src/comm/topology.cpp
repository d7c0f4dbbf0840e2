#include "comm/topology.hpp"

#include <algorithm>
#include <cmath>

#include "comm/key_map.hpp"

namespace moraine {

template <int Dim>
DomainBlocks<Dim>::DomainBlocks(const Scene& scene) {
    const Stencil stencil = stencil_of(scene.shape);
    for (int a = 0; a < Dim; ++a) {
        const auto s = static_cast<std::size_t>(a);
        nodes[s] = static_cast<std::int32_t>(std::lround((scene.max[s] - scene.min[s]) / scene.cell));
        periodic[s] = scene.periodic[s];
        count[s] =
            periodic[s] ? nodes[s] / 4 : static_cast<std::int32_t>(std::floor((nodes[s] + stencil.offset()) / 4)) + 1;
    }
}

template <int Dim>
bool DomainBlocks<Dim>::wrap(BlockPosition<Dim>& at) const {
    bool inside = true;
    for (std::size_t a = 0; a < Dim; ++a) {
        if (periodic[a]) at[a] = (at[a] % count[a] + count[a]) % count[a];
        inside = inside && at[a] >= 0 && at[a] < count[a];
    }
    return inside;
}

template <int Dim>
std::int64_t Topology<Dim>::find(Key key) const {
    const auto it = std::lower_bound(keys.begin(), keys.end(), key);
    return it != keys.end() && *it == key ? it - keys.begin() : -1;
}

namespace {

/// Neighbour of `at` at offset `code`; false: outside the domain.
template <int Dim>
bool neighbour(const DomainBlocks<Dim>& domain, const BlockPosition<Dim>& at, int code, BlockPosition<Dim>& result) {
    for (int a = 0; a < Dim; ++a)
        result[static_cast<std::size_t>(a)] = at[static_cast<std::size_t>(a)] + Block<Dim>::offset(code, a);
    return domain.wrap(result);
}

/// Empty blocks beside occupied ones, sorted.
template <int Dim>
std::vector<Key> apron_of(const DomainBlocks<Dim>& domain, const std::vector<Key>& keys, const KeyMap& place) {
    std::vector<Key> apron;
#pragma omp parallel
    {
        std::vector<Key> mine;
        BlockPosition<Dim> near{};
#pragma omp for schedule(static) nowait
        for (std::size_t i = 0; i < keys.size(); ++i) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(keys[i]);
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                if (!neighbour<Dim>(domain, at, code, near)) continue;
                const Key key = Morton<Dim>::encode(near);
                if (place.find(key) < 0) mine.push_back(key);
            }
        }
        std::sort(mine.begin(), mine.end());
        mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
#pragma omp critical
        apron.insert(apron.end(), mine.begin(), mine.end());
    }
    std::sort(apron.begin(), apron.end());
    apron.erase(std::unique(apron.begin(), apron.end()), apron.end());
    return apron;
}

}  // namespace

template <int Dim>
Topology<Dim> make_topology(const DomainBlocks<Dim>& domain, const std::vector<OccupiedBlock>& occupied,
                            const std::function<std::int32_t(const BlockPosition<Dim>&)>& owner_at) {
    std::vector<Key> keys;
    keys.reserve(occupied.size());
    for (const OccupiedBlock& b : occupied) keys.push_back(b.key);
    const KeyMap place(keys);
    const std::vector<Key> apron = apron_of<Dim>(domain, keys, place);

    Topology<Dim> t;
    t.keys.resize(keys.size() + apron.size());
    std::merge(keys.begin(), keys.end(), apron.begin(), apron.end(), t.keys.begin());
    t.owner.assign(t.keys.size(), -1);
    for (std::size_t i = 0; i < t.keys.size(); ++i) {
        const std::int32_t here = place.find(t.keys[i]);
        if (here >= 0) {
            t.owner[i] = occupied[static_cast<std::size_t>(here)].owner;
            continue;
        }
        const BlockPosition<Dim> at = Morton<Dim>::decode(t.keys[i]);
        BlockPosition<Dim> near{};
        t.owner[i] = owner_at(at);
        for (int code = 0; t.owner[i] < 0 && code < Block<Dim>::offsets; ++code) {
            if (!neighbour<Dim>(domain, at, code, near)) continue;
            const std::int32_t there = place.find(Morton<Dim>::encode(near));
            if (there >= 0) t.owner[i] = occupied[static_cast<std::size_t>(there)].owner;
        }
    }
    return t;
}

template struct DomainBlocks<2>;
template struct DomainBlocks<3>;
template struct Topology<2>;
template struct Topology<3>;
template Topology<2> make_topology<2>(const DomainBlocks<2>&, const std::vector<OccupiedBlock>&,
                                      const std::function<std::int32_t(const BlockPosition<2>&)>&);
template Topology<3> make_topology<3>(const DomainBlocks<3>&, const std::vector<OccupiedBlock>&,
                                      const std::function<std::int32_t(const BlockPosition<3>&)>&);

}  // namespace moraine
