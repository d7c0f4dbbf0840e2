#include "blocks/epoch.hpp"

#include <algorithm>
#include <atomic>
#include <limits>

#include "blocks/growth.hpp"
#include "blocks/guard_layer.hpp"
#include "blocks/halo_lists.hpp"
#include "blocks/in_order.hpp"

namespace moraine {

namespace {

template <int Dim>
Vec<std::int32_t, Dim> as_vec(const BlockPosition<Dim>& at) {
    Vec<std::int32_t, Dim> v;
    for (int a = 0; a < Dim; ++a) v[a] = at[static_cast<std::size_t>(a)];
    return v;
}

template <int Dim>
class Builder {
  public:
    Builder(const Topology<Dim>& topology, const DomainBlocks<Dim>& domain, const Stencil& stencil, int rank)
        : topology_(topology), domain_(domain), stencil_(stencil), rank_(rank) {}

    EpochTables<Dim> build() {
        list_own();
        link_blocks();
        number_ghosts();
        link_ghosts();
        make_node_blocks();
        describe_node_blocks();
        e_.peers = halo_lists(e_, stencil_.width);
        return std::move(e_);
    }

  private:
    static constexpr unsigned children = Block<Dim>::corners;
    static constexpr std::size_t offsets = Block<Dim>::offsets;
    static constexpr std::size_t corners = Block<Dim>::corners;

    /// In local_: block s of the topology is another rank's and no ghost (so far).
    static std::int32_t foreign(std::size_t s) { return -2 - static_cast<std::int32_t>(s); }
    static std::size_t block_of(std::int32_t foreign) { return static_cast<std::size_t>(-2 - foreign); }

    std::uint32_t own_blocks(const Family& family) const {
        std::uint32_t mask = 0;
        for (unsigned child = 0; child < children; ++child)
            if (family.has(child) && topology_.owner[static_cast<std::size_t>(family.index_of(child))] == rank_)
                mask |= 1u << child;
        return mask;
    }

    void list_own() {
        const std::vector<Family>& all = topology_.index.families();
        std::vector<std::uint32_t> mask(all.size());
#pragma omp parallel for schedule(static)
        for (std::size_t f = 0; f < all.size(); ++f) mask[f] = own_blocks(all[f]);
        std::vector<Family> own;
        place_in_order(
            all.size(), [&](std::size_t f) { return mask[f] != 0; }, [&](std::size_t size) { own.resize(size); },
            [&](std::size_t f, std::size_t at) {
                own[at] = {all[f].parent, 0, mask[f]};
            });
        own_ = BlockIndex<Dim>(std::move(own));
        e_.own = own_.keys();
        local_.resize(topology_.keys.size());
#pragma omp parallel for schedule(static)
        for (const Family& family : all) {
            const Family mine = own_family(family.parent);
            for (unsigned child = 0; child < children; ++child) {
                if (!family.has(child)) continue;
                const auto s = static_cast<std::size_t>(family.index_of(child));
                local_[s] = mine.has(child) ? mine.index_of(child) : foreign(s);
            }
        }
    }

    Family own_family(Key parent) const {
        const std::int32_t f = own_.family(parent);
        return f < 0 ? Family{parent, 0, 0} : own_.families()[static_cast<std::size_t>(f)];
    }

    /// local_ of the blocks that a family's reach, -1 where there is none.
    auto local_around(const Family& family, const Surroundings<Dim>& near,
                      const std::array<Places, children>& reach) const {
        auto blocks = blocks_at(topology_.index, near, PlaceTables<Dim>::of(family.mask, reach));
        for (std::int32_t& block : blocks) block = block < 0 ? -1 : local_[static_cast<std::size_t>(block)];
        return blocks;
    }

    static std::uint64_t guard_layer_of(unsigned child, Places absent) {
        std::uint64_t guard_layer = 0;
        for (std::size_t code = 0; (absent & place_tables<Dim>.around[child]) != 0 && code < offsets; ++code)
            if (absent >> place_tables<Dim>.at[child][code] & 1u) guard_layer |= guard_layers<Dim>[code];
        return guard_layer;
    }

    bool at_face(const BlockPosition<Dim>& at, int last) const {
        bool face = false;
        for (std::size_t a = 0; a < Dim; ++a)
            face = face ||
                   (!domain_.periodic[a] && (at[a] <= 0 || 4 * at[a] - stencil_.origin + last >= domain_.nodes[a]));
        return face;
    }

    /// Foreign neighbours have no number yet: they are marked, and entered as what local_ says.
    void link_blocks() {
        e_.position.resize(e_.own.size());
        e_.border.resize(e_.own.size());
        e_.guard_layer.resize(e_.own.size());
        e_.neighbour.resize(e_.own.size() * offsets);
        next_to_foreign_.resize(e_.own.size());
        is_ghost_.resize(topology_.keys.size());
#pragma omp parallel for schedule(static)
        for (const Family& family : own_.families()) {
            const Surroundings<Dim> places(domain_, family.parent, Ends::closed);
            const auto near = local_around(family, places, place_tables<Dim>.around);
            Places foreign_near = 0, absent = 0, ghosts = 0;
            for (std::size_t p = 0; p < near.size(); ++p) {
                foreign_near |= Places(near[p] < -1) << p;
                absent |= Places(near[p] == -1) << p;
            }
            absent &= places.inside();
            for (unsigned child = 0; child < children; ++child) {
                if (!family.has(child)) continue;
                const auto i = static_cast<std::size_t>(family.index_of(child));
                const BlockPosition<Dim> at = Morton<Dim>::decode(e_.own[i]);
                e_.position[i] = as_vec<Dim>(at);
                e_.border[i] = at_face(at, 4 + stencil_.width);
                e_.guard_layer[i] = guard_layer_of(child, absent);
                for (std::size_t code = 0; code < offsets; ++code)
                    e_.neighbour[i * offsets + code] = near[place_tables<Dim>.at[child][code]];
                next_to_foreign_[i] = (foreign_near & place_tables<Dim>.around[child]) != 0;
                ghosts |= foreign_near & place_tables<Dim>.around[child];
            }
            for (; ghosts != 0; ghosts &= ghosts - 1)
                std::atomic_ref(is_ghost_[block_of(near[static_cast<std::size_t>(std::countr_zero(ghosts))])])
                    .store(1, std::memory_order_relaxed);
        }
    }

    /// By owner, then key.
    void number_ghosts() {
        const auto blocks = chosen_of<std::size_t>(is_ghost_.size(), [&](std::size_t s) { return is_ghost_[s] != 0; });
        std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = -1;
#pragma omp parallel for schedule(static) reduction(min : low) reduction(max : high)
        for (std::size_t s : blocks) low = std::min(low, topology_.owner[s]), high = std::max(high, topology_.owner[s]);
        const Grouped by_owner =
            grouped_in_order(blocks.size(), blocks.empty() ? 0 : static_cast<std::size_t>(high - low + 1),
                             [&](std::size_t k) { return topology_.owner[blocks[k]] - low; });
        e_.ghost.resize(blocks.size());
        e_.ghost_owner.resize(blocks.size());
#pragma omp parallel for schedule(static)
        for (std::size_t g = 0; g < blocks.size(); ++g) {
            const std::size_t s = blocks[by_owner.item[g]];
            e_.ghost[g] = topology_.keys[s];
            e_.ghost_owner[g] = topology_.owner[s];
            local_[s] = static_cast<std::int32_t>(e_.own.size() + g);
        }
    }

    void link_ghosts() {
        const std::size_t own = e_.own.size();
        e_.boundary = chosen_of<std::int32_t>(own, [&](std::size_t i) { return next_to_foreign_[i] != 0; });
        e_.interior = chosen_of<std::int32_t>(own, [&](std::size_t i) { return next_to_foreign_[i] == 0; });
#pragma omp parallel for schedule(static)
        for (std::int32_t i : e_.boundary)
            for (std::size_t code = 0; code < offsets; ++code) {
                std::int32_t& neighbour = e_.neighbour[static_cast<std::size_t>(i) * offsets + code];
                if (neighbour < -1) neighbour = local_[block_of(neighbour)];
            }
    }

    /// Own blocks, and those at their upper corners that are not.
    void make_node_blocks() {
        nodes_ = grown(own_, domain_, Reach::upwards);
        e_.node_key = nodes_.keys();
        e_.node_block.resize(e_.own.size() * corners);
#pragma omp parallel for schedule(static)
        for (const Family& family : own_.families()) {
            const auto near = blocks_at(nodes_, Surroundings<Dim>(domain_, family.parent, Ends::open),
                                        PlaceTables<Dim>::of(family.mask, place_tables<Dim>.upwards));
            for (unsigned child = 0; child < children; ++child)
                for (std::size_t delta = 0; family.has(child) && delta < corners; ++delta)
                    e_.node_block[static_cast<std::size_t>(family.index_of(child)) * corners + delta] =
                        near[place_tables<Dim>.at[child][corner_code<Dim>(static_cast<int>(delta), 1)]];
        }
    }

    void describe_node_blocks() {
        e_.node_position.resize(e_.node_key.size());
        e_.node_border.resize(e_.node_key.size());
        e_.source.resize(e_.node_key.size() * corners);
#pragma omp parallel for schedule(static)
        for (const Family& family : nodes_.families()) {
            const Surroundings<Dim> places(domain_, family.parent, Ends::open);
            const auto near = local_around(family, places, place_tables<Dim>.downwards);
            for (unsigned child = 0; child < children; ++child) {
                if (!family.has(child)) continue;
                const auto i = static_cast<std::size_t>(family.index_of(child));
                const BlockPosition<Dim> at = Morton<Dim>::decode(e_.node_key[i]);
                e_.node_position[i] = as_vec<Dim>(at);
                e_.node_border[i] = at_face(at, 3);
                for (std::size_t delta = 0; delta < corners; ++delta)
                    e_.source[i * corners + delta] =
                        std::max(-1, near[place_tables<Dim>.at[child][corner_code<Dim>(static_cast<int>(delta), -1)]]);
            }
        }
    }

    const Topology<Dim>& topology_;
    const DomainBlocks<Dim>& domain_;
    const Stencil stencil_;
    const int rank_;
    EpochTables<Dim> e_;
    BlockIndex<Dim> own_, nodes_;
    std::vector<std::int32_t> local_;  ///< of each block of the topology: own index, own + ghost index, or foreign()
    std::vector<std::uint8_t> next_to_foreign_;  ///< own
    std::vector<std::uint8_t> is_ghost_;         ///< topology
};

}  // namespace

template <int Dim>
std::int32_t EpochTables<Dim>::find_own(Key key) const {
    const auto it = std::lower_bound(own.begin(), own.end(), key);
    return it != own.end() && *it == key ? static_cast<std::int32_t>(it - own.begin()) : -1;
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
