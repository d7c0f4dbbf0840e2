#include "comm/topology.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace

template <int Dim>
Topology<Dim> make_topology(const DomainBlocks<Dim>& domain, const std::vector<OccupiedBlock>& occupied,
                            const std::function<std::int32_t(const BlockPosition<Dim>&)>& owner_at) {
    Topology<Dim> t;
    t.keys.reserve(occupied.size() * 2);
    BlockPosition<Dim> near{};
    for (const OccupiedBlock& b : occupied) {
        const BlockPosition<Dim> at = Morton<Dim>::decode(b.key);
        for (int code = 0; code < Block<Dim>::offsets; ++code)
            if (neighbour<Dim>(domain, at, code, near)) t.keys.push_back(Morton<Dim>::encode(near));
    }
    std::sort(t.keys.begin(), t.keys.end());
    t.keys.erase(std::unique(t.keys.begin(), t.keys.end()), t.keys.end());
    t.owner.assign(t.keys.size(), -1);
    const auto owner_of_occupied = [&](Key key) {
        const auto it = std::lower_bound(occupied.begin(), occupied.end(), key,
                                         [](const OccupiedBlock& b, Key k) { return b.key < k; });
        return it != occupied.end() && it->key == key ? it->owner : -1;
    };
    for (std::size_t i = 0; i < t.keys.size(); ++i) {
        t.owner[i] = owner_of_occupied(t.keys[i]);
        if (t.owner[i] >= 0) continue;
        const BlockPosition<Dim> at = Morton<Dim>::decode(t.keys[i]);
        t.owner[i] = owner_at(at);
        for (int code = 0; t.owner[i] < 0 && code < Block<Dim>::offsets; ++code)
            if (neighbour<Dim>(domain, at, code, near)) t.owner[i] = owner_of_occupied(Morton<Dim>::encode(near));
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
