#include "comm/epoch.hpp"

#include <algorithm>
#include <map>

#include "comm/key_map.hpp"

namespace moraine {

namespace {

template <int Dim>
Vec<std::int32_t, Dim> as_vec(const BlockPosition<Dim>& at) {
    Vec<std::int32_t, Dim> v;
    for (int a = 0; a < Dim; ++a) v[a] = at[static_cast<std::size_t>(a)];
    return v;
}

std::int32_t index_of(const std::vector<Key>& keys, Key key) {
    const auto it = std::lower_bound(keys.begin(), keys.end(), key);
    return it != keys.end() && *it == key ? static_cast<std::int32_t>(it - keys.begin()) : -1;
}

/// Nodes of a tile that blocks at the offsets of `mask` share with it, ascending.
template <int Dim>
std::vector<std::uint16_t> overlap_nodes(std::uint32_t mask, int width) {
    const int side = tile_side(width);
    std::vector<std::uint16_t> nodes;
    for (int n = 0; n < power<Dim>(side); ++n) {
        const int at[3] = {n % side, n / side % side, n / (side * side)};
        for (int code = 0; code < Block<Dim>::offsets; ++code) {
            if (!(mask >> code & 1u)) continue;
            bool inside = true;
            for (int a = 0; a < Dim; ++a) {
                const int eta = Block<Dim>::offset(code, a);
                inside = inside && (eta == 0 || (eta > 0 ? at[a] >= 4 : at[a] < width - 1));
            }
            if (inside) {
                nodes.push_back(static_cast<std::uint16_t>(n));
                break;
            }
        }
    }
    return nodes;
}

template <int Dim>
class Builder {
  public:
    Builder(const Topology<Dim>& topology, const DomainBlocks<Dim>& domain, const Stencil& stencil, int rank)
        : topology_(topology), domain_(domain), stencil_(stencil), rank_(rank) {}

    EpochTables<Dim> build() {
        for (std::size_t i = 0; i < topology_.keys.size(); ++i)
            if (topology_.owner[i] == rank_) e_.own.push_back(topology_.keys[i]);
        own_index_ = KeyMap(e_.own);
        if (e_.own.size() < topology_.keys.size()) find_ghosts();
        ghost_index_ = KeyMap(e_.ghost);
        link_blocks();
        make_node_blocks();
        make_halo();
        return std::move(e_);
    }

  private:
    bool shifted(const BlockPosition<Dim>& from, int code, BlockPosition<Dim>& to) const {
        for (int a = 0; a < Dim; ++a)
            to[static_cast<std::size_t>(a)] = from[static_cast<std::size_t>(a)] + Block<Dim>::offset(code, a);
        return domain_.wrap(to);
    }

    void find_ghosts() {
        const KeyMap all(topology_.keys);
        std::vector<std::pair<std::int32_t, Key>> foreign;
        BlockPosition<Dim> near{};
        for (Key key : e_.own) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(key);
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                if (!shifted(at, code, near)) continue;
                const std::int32_t i = all.find(Morton<Dim>::encode(near));
                if (i < 0) continue;
                const std::int32_t owner = topology_.owner[static_cast<std::size_t>(i)];
                if (owner != rank_) foreign.emplace_back(owner, topology_.keys[static_cast<std::size_t>(i)]);
            }
        }
        std::sort(foreign.begin(), foreign.end());
        foreign.erase(std::unique(foreign.begin(), foreign.end()), foreign.end());
        for (const auto& [owner, key] : foreign) {
            e_.ghost.push_back(key);
            e_.ghost_owner.push_back(owner);
        }
    }

    /// Own index, own count + ghost index, or -1.
    std::int32_t local(Key key) const {
        const std::int32_t own = own_index_.find(key);
        if (own >= 0) return own;
        const std::int32_t ghost = ghost_index_.find(key);
        return ghost < 0 ? -1 : static_cast<std::int32_t>(e_.own.size()) + ghost;
    }

    void link_blocks() {
        const std::size_t n = e_.own.size();
        e_.position.resize(n);
        e_.border.resize(n);
        e_.neighbour.resize(n * Block<Dim>::offsets);
#pragma omp parallel for schedule(static)
        for (std::size_t i = 0; i < n; ++i) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(e_.own[i]);
            BlockPosition<Dim> near{};
            e_.position[i] = as_vec<Dim>(at);
            bool border = false;
            for (std::size_t a = 0; a < Dim; ++a)
                border =
                    border || (!domain_.periodic[a] &&
                               (at[a] <= 0 || 4 * at[a] - stencil_.origin + 4 + stencil_.width >= domain_.nodes[a]));
            e_.border[i] = border;
            for (int code = 0; code < Block<Dim>::offsets; ++code)
                e_.neighbour[i * Block<Dim>::offsets + static_cast<std::size_t>(code)] =
                    shifted(at, code, near) ? local(Morton<Dim>::encode(near)) : -1;
        }
    }

    /// Block at `at` + sign * delta, wrapped where the axis is periodic.
    BlockPosition<Dim> corner(BlockPosition<Dim> at, int delta, int sign) const {
        for (int a = 0; a < Dim; ++a) at[static_cast<std::size_t>(a)] += sign * Block<Dim>::corner(delta, a);
        domain_.wrap(at);
        return at;
    }

    /// The neighbour of own block i at corner delta upwards (sign 1) or downwards (-1): own, own + ghost index, or -1.
    std::int32_t beside(std::size_t i, int delta, int sign) const {
        int code = 0;
        for (int a = Dim - 1; a >= 0; --a) code = 3 * code + 1 + sign * Block<Dim>::corner(delta, a);
        return delta == 0 ? static_cast<std::int32_t>(i)
                          : e_.neighbour[i * Block<Dim>::offsets + static_cast<std::size_t>(code)];
    }

    /// Own blocks, and those at their upper corners that are not.
    void find_node_blocks() {
        std::vector<Key> others;
        for (std::size_t i = 0; i < e_.own.size(); ++i)
            for (int delta = 1; delta < Block<Dim>::corners; ++delta) {
                const std::int32_t up = beside(i, delta, 1);
                if (up < 0 || up >= static_cast<std::int32_t>(e_.own.size()))
                    others.push_back(Morton<Dim>::encode(corner(Morton<Dim>::decode(e_.own[i]), delta, 1)));
            }
        std::sort(others.begin(), others.end());
        others.erase(std::unique(others.begin(), others.end()), others.end());
        e_.node_key.resize(e_.own.size() + others.size());
        std::merge(e_.own.begin(), e_.own.end(), others.begin(), others.end(), e_.node_key.begin());
    }

    void make_node_blocks() {
        constexpr std::size_t corners = Block<Dim>::corners;
        find_node_blocks();
        const KeyMap index(e_.node_key);
        std::vector<std::int32_t> node_of_own(e_.own.size()), own_of_node(e_.node_key.size(), -1);
        for (std::size_t i = 0, n = 0; i < e_.own.size(); ++i, ++n) {
            while (e_.node_key[n] != e_.own[i]) ++n;
            node_of_own[i] = static_cast<std::int32_t>(n);
            own_of_node[n] = static_cast<std::int32_t>(i);
        }
        e_.node_block.resize(e_.own.size() * corners);
#pragma omp parallel for schedule(static)
        for (std::size_t i = 0; i < e_.own.size(); ++i)
            for (std::size_t delta = 0; delta < corners; ++delta) {
                const std::int32_t up = beside(i, static_cast<int>(delta), 1);
                const bool own = up >= 0 && up < static_cast<std::int32_t>(e_.own.size());
                e_.node_block[i * corners + delta] =
                    own ? node_of_own[static_cast<std::size_t>(up)]
                        : index.find(
                              Morton<Dim>::encode(corner(Morton<Dim>::decode(e_.own[i]), static_cast<int>(delta), 1)));
            }
        describe_node_blocks(own_of_node);
    }

    void describe_node_blocks(const std::vector<std::int32_t>& own_of_node) {
        constexpr std::size_t corners = Block<Dim>::corners;
        const std::size_t n = e_.node_key.size();
        e_.node_position.resize(n);
        e_.node_border.resize(n);
        e_.source.resize(n * corners);
#pragma omp parallel for schedule(static)
        for (std::size_t i = 0; i < n; ++i) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(e_.node_key[i]);
            e_.node_position[i] = as_vec<Dim>(at);
            bool border = false;
            for (std::size_t a = 0; a < Dim; ++a)
                border = border ||
                         (!domain_.periodic[a] && (at[a] <= 0 || 4 * at[a] - stencil_.origin + 3 >= domain_.nodes[a]));
            e_.node_border[i] = border;
            for (std::size_t delta = 0; delta < corners; ++delta) {
                const auto d = static_cast<int>(delta);
                e_.source[i * corners + delta] = own_of_node[i] >= 0
                                                     ? beside(static_cast<std::size_t>(own_of_node[i]), d, -1)
                                                     : local(Morton<Dim>::encode(corner(at, d, -1)));
            }
        }
    }

    void make_halo() {
        std::map<int, std::map<std::int32_t, std::uint32_t>> sends, receives;  // peer -> block -> offsets
        const auto own = static_cast<std::int32_t>(e_.own.size());
        for (std::int32_t b = 0; b < own && !e_.ghost.empty(); ++b)
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                const std::int32_t n = e_.neighbour[static_cast<std::size_t>(b * Block<Dim>::offsets + code)];
                if (n < own) continue;
                const int peer = e_.ghost_owner[static_cast<std::size_t>(n - own)];
                sends[peer][b] |= 1u << code;
                receives[peer][n - own] |= 1u << Block<Dim>::opposite(code);
            }
        std::vector<std::uint8_t> needed(e_.own.size(), 0);
        for (auto& [peer, blocks] : sends) {
            for (auto& [b, mask] : blocks) needed[static_cast<std::size_t>(b)] = 1;
            PeerHalo halo{peer, tile_list(blocks), tile_list(receives[peer]), 0, 0};
            halo.ghost_begin = halo.receive.block.front();
            halo.ghost_end = halo.receive.block.back() + 1;
            e_.peers.push_back(std::move(halo));
        }
        for (std::int32_t b = 0; b < own; ++b)
            (needed[static_cast<std::size_t>(b)] ? e_.boundary : e_.interior).push_back(b);
    }

    TileList tile_list(const std::map<std::int32_t, std::uint32_t>& blocks) {
        TileList list;
        list.first.push_back(0);
        for (const auto& [block, mask] : blocks) {
            auto [it, fresh] = nodes_.try_emplace(mask);
            if (fresh) it->second = overlap_nodes<Dim>(mask, stencil_.width);
            list.block.push_back(block);
            list.node.insert(list.node.end(), it->second.begin(), it->second.end());
            list.first.push_back(static_cast<std::uint32_t>(list.node.size()));
        }
        return list;
    }

    const Topology<Dim>& topology_;
    const DomainBlocks<Dim>& domain_;
    const Stencil stencil_;
    const int rank_;
    EpochTables<Dim> e_;
    KeyMap own_index_, ghost_index_;
    std::map<std::uint32_t, std::vector<std::uint16_t>> nodes_;
};

}  // namespace

template <int Dim>
std::int32_t EpochTables<Dim>::find_own(Key key) const {
    return index_of(own, key);
}

template <int Dim>
EpochTables<Dim> make_epoch(const Topology<Dim>& topology, const DomainBlocks<Dim>& domain, const Stencil& stencil,
                            int rank) {
    return Builder<Dim>(topology, domain, stencil, rank).build();
}

template struct EpochTables<2>;
template struct EpochTables<3>;
template EpochTables<2> make_epoch<2>(const Topology<2>&, const DomainBlocks<2>&, const Stencil&, int);
template EpochTables<3> make_epoch<3>(const Topology<3>&, const DomainBlocks<3>&, const Stencil&, int);

}  // namespace moraine
