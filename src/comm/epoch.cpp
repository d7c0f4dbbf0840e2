#include "comm/epoch.hpp"

#include <algorithm>
#include <map>

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
        find_ghosts();
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
        std::map<Key, std::int32_t> foreign;
        BlockPosition<Dim> near{};
        for (Key key : e_.own) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(key);
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                if (!shifted(at, code, near)) continue;
                const std::int64_t i = topology_.find(Morton<Dim>::encode(near));
                if (i >= 0 && topology_.owner[static_cast<std::size_t>(i)] != rank_)
                    foreign[topology_.keys[static_cast<std::size_t>(i)]] = topology_.owner[static_cast<std::size_t>(i)];
            }
        }
        std::vector<std::pair<std::int32_t, Key>> order;
        for (const auto& [key, owner] : foreign) order.emplace_back(owner, key);
        std::sort(order.begin(), order.end());
        for (std::size_t g = 0; g < order.size(); ++g) {
            e_.ghost.push_back(order[g].second);
            e_.ghost_owner.push_back(order[g].first);
            ghost_index_[order[g].second] = static_cast<std::int32_t>(g);
        }
    }

    /// Own index, own count + ghost index, or -1.
    std::int32_t local(Key key) const {
        const std::int32_t own = index_of(e_.own, key);
        if (own >= 0) return own;
        const auto it = ghost_index_.find(key);
        return it == ghost_index_.end() ? -1 : static_cast<std::int32_t>(e_.own.size()) + it->second;
    }

    void link_blocks() {
        BlockPosition<Dim> near{};
        for (Key key : e_.own) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(key);
            e_.position.push_back(as_vec<Dim>(at));
            bool border = false;
            for (std::size_t a = 0; a < Dim; ++a)
                border =
                    border || (!domain_.periodic[a] &&
                               (at[a] <= 0 || 4 * at[a] - stencil_.origin + 4 + stencil_.width >= domain_.nodes[a]));
            e_.border.push_back(border);
            for (int code = 0; code < Block<Dim>::offsets; ++code)
                e_.neighbour.push_back(shifted(at, code, near) ? local(Morton<Dim>::encode(near)) : -1);
        }
    }

    /// Block at `at` + sign * delta, wrapped where the axis is periodic.
    BlockPosition<Dim> corner(BlockPosition<Dim> at, int delta, int sign) const {
        for (int a = 0; a < Dim; ++a) at[static_cast<std::size_t>(a)] += sign * Block<Dim>::corner(delta, a);
        domain_.wrap(at);
        return at;
    }

    void make_node_blocks() {
        for (Key key : e_.own)
            for (int delta = 0; delta < Block<Dim>::corners; ++delta)
                e_.node_key.push_back(Morton<Dim>::encode(corner(Morton<Dim>::decode(key), delta, 1)));
        std::vector<Key> all = e_.node_key;
        std::sort(e_.node_key.begin(), e_.node_key.end());
        e_.node_key.erase(std::unique(e_.node_key.begin(), e_.node_key.end()), e_.node_key.end());
        for (Key key : all) e_.node_block.push_back(index_of(e_.node_key, key));
        for (Key key : e_.node_key) {
            const BlockPosition<Dim> at = Morton<Dim>::decode(key);
            e_.node_position.push_back(as_vec<Dim>(at));
            bool border = false;
            for (std::size_t a = 0; a < Dim; ++a)
                border = border ||
                         (!domain_.periodic[a] && (at[a] <= 0 || 4 * at[a] - stencil_.origin + 3 >= domain_.nodes[a]));
            e_.node_border.push_back(border);
            for (int delta = 0; delta < Block<Dim>::corners; ++delta)
                e_.source.push_back(local(Morton<Dim>::encode(corner(at, delta, -1))));
        }
    }

    void make_halo() {
        std::map<int, std::map<std::int32_t, std::uint32_t>> sends, receives;  // peer -> block -> offsets
        const auto own = static_cast<std::int32_t>(e_.own.size());
        for (std::int32_t b = 0; b < own; ++b)
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
    std::map<Key, std::int32_t> ghost_index_;
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
