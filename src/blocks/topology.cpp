#include "blocks/topology.hpp"

#include <cmath>

#include "blocks/growth.hpp"

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

namespace {

Family family_in(const auto& index, Key parent) {
    const std::int32_t f = index.family(parent);
    return f < 0 ? Family{parent, 0, 0} : index.families()[static_cast<std::size_t>(f)];
}

/// Owners of a family's blocks: those of occupied blocks are known; an empty one's is that of before, or said by its
/// position, or it has that of its first occupied neighbour.
template <int Dim>
void set_owners(Topology<Dim>& t, const Family& family, const DomainBlocks<Dim>& domain,
                const std::vector<OccupiedBlock>& occupied, const BlockIndex<Dim>& filled,
                const std::function<std::int32_t(const BlockPosition<Dim>&)>& owner_at, const Topology<Dim>* before) {
    const Family known = family_in(filled, family.parent);
    const Family old = before ? family_in(before->index, family.parent) : Family{family.parent, 0, 0};
    const auto owner_of = [&](std::int32_t block) { return occupied[static_cast<std::size_t>(block)].owner; };
    std::array<std::int32_t, Surroundings<Dim>::places> near;
    Places there = 0;
    if (((known.mask | old.mask) & family.mask) != family.mask) {
        const PlaceTables<Dim>& table = place_tables<Dim>;
        near = blocks_at(filled, Surroundings<Dim>(domain, family.parent, Ends::closed),
                         table.of(family.mask & ~known.mask & ~old.mask, table.around));
        for (std::size_t p = 0; p < near.size(); ++p) there |= Places(near[p] >= 0) << p;
    }
    for (unsigned child = 0; child < Block<Dim>::corners; ++child) {
        if (!family.has(child)) continue;
        std::int32_t& owner = t.owner[static_cast<std::size_t>(family.index_of(child))];
        if (known.has(child)) {
            owner = owner_of(known.index_of(child));
            continue;
        }
        if (old.has(child)) {
            owner = before->owner[static_cast<std::size_t>(old.index_of(child))];
            continue;
        }
        owner = owner_at(Morton<Dim>::decode((family.parent << Dim) + child));
        // Places and offset codes ascend alike.
        for (Places adjacent = there & place_tables<Dim>.around[child]; owner < 0 && adjacent != 0;
             adjacent &= adjacent - 1)
            owner = owner_of(near[static_cast<std::size_t>(std::countr_zero(adjacent))]);
    }
}

}  // namespace

template <int Dim>
Topology<Dim> make_topology(const DomainBlocks<Dim>& domain, const std::vector<OccupiedBlock>& occupied,
                            const std::function<std::int32_t(const BlockPosition<Dim>&)>& owner_at,
                            const Topology<Dim>* before) {
    std::vector<Key> keys(occupied.size());
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = occupied[i].key;
    const BlockIndex<Dim> filled(keys);

    Topology<Dim> t;
    t.index = grown(filled, domain, Reach::around);
    t.keys = t.index.keys();
    t.owner.resize(t.keys.size());
    const std::vector<Family>& families = t.index.families();
#pragma omp parallel for schedule(static)
    for (std::size_t f = 0; f < families.size(); ++f)
        set_owners<Dim>(t, families[f], domain, occupied, filled, owner_at, before);
    return t;
}

template struct DomainBlocks<2>;
template struct DomainBlocks<3>;
template struct Topology<2>;
template struct Topology<3>;
template Topology<2> make_topology<2>(const DomainBlocks<2>&, const std::vector<OccupiedBlock>&,
                                      const std::function<std::int32_t(const BlockPosition<2>&)>&, const Topology<2>*);
template Topology<3> make_topology<3>(const DomainBlocks<3>&, const std::vector<OccupiedBlock>&,
                                      const std::function<std::int32_t(const BlockPosition<3>&)>&, const Topology<3>*);

}  // namespace moraine
