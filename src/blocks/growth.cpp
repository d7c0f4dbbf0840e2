#include "blocks/growth.hpp"

#include <atomic>

#include "blocks/in_order.hpp"

namespace moraine {

namespace {

void add_blocks(Family& family, std::uint32_t blocks) {
    const std::atomic_ref mask(family.mask);
    if (blocks & ~mask.load(std::memory_order_relaxed)) mask.fetch_or(blocks, std::memory_order_relaxed);
}

/// Blocks reached from a family, by the slot in which they lie.
template <int Dim>
std::array<std::uint8_t, Block<Dim>::offsets> reached_from(const Family& family, const Surroundings<Dim>& near,
                                                           Reach reach) {
    const PlaceTables<Dim>& table = place_tables<Dim>;
    Places all = table.of(family.mask, reach == Reach::around ? table.around : table.upwards);
    std::array<std::uint8_t, Block<Dim>::offsets> blocks{};
    for (all &= near.inside(); all != 0; all &= all - 1) {
        const auto [slot, child] = near.cell(std::countr_zero(all));
        blocks[slot] = static_cast<std::uint8_t>(blocks[slot] | 1u << child);
    }
    return blocks;
}

std::vector<Family> joined(const std::vector<std::vector<Family>>& lists) {
    std::vector<std::size_t> first{0};
    for (const std::vector<Family>& list : lists) first.push_back(first.back() + list.size());
    std::vector<Family> all(first.back());
#pragma omp parallel for schedule(static) if (lists.size() > 1)
    for (std::size_t l = 0; l < lists.size(); ++l)
        std::copy(lists[l].begin(), lists[l].end(), all.begin() + static_cast<std::ptrdiff_t>(first[l]));
    return all;
}

/// Adds what the families of `index` reach to `families`, which are the same ones, and returns what lies in others.
template <int Dim>
std::vector<Family> add_reached(std::vector<Family>& families, const BlockIndex<Dim>& index,
                                const DomainBlocks<Dim>& domain, Reach reach) {
    const Parts parts(families.size());
    std::vector<std::vector<Family>> others(parts.count);
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t p = 0; p < parts.count; ++p)
        for (std::size_t f = parts.begin(p); f < parts.end(p); ++f) {
            const Family& from = index.families()[f];
            const Surroundings<Dim> near(domain, from.parent, reach == Reach::around ? Ends::closed : Ends::open);
            const auto blocks = reached_from<Dim>(from, near, reach);
            for (int slot = 0; slot < Block<Dim>::offsets; ++slot) {
                const std::uint8_t mask = blocks[static_cast<std::size_t>(slot)];
                if (mask == 0) continue;
                const std::int32_t to = index.family(near.parent(slot));
                if (to >= 0)
                    add_blocks(families[static_cast<std::size_t>(to)], mask);
                else
                    others[p].push_back({near.parent(slot), 0, mask});
            }
        }
    return joined(others);
}

/// One of each parent, with the blocks of all; the order is any.
std::vector<Family> unique_of(std::vector<Family> list) {
    FamilyTable table(list.size());
    const Parts parts(list.size());
    std::vector<std::uint8_t> stays(list.size());
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t i = 0; i < list.size(); ++i) {
        const auto there = static_cast<std::size_t>(table.insert(list, static_cast<std::int32_t>(i)));
        stays[i] = there == i;
        if (there != i) add_blocks(list[there], list[i].mask);
    }
    std::vector<Family> result;
    place_in_order(
        list.size(), [&](std::size_t i) { return stays[i]; }, [&](std::size_t size) { result.resize(size); },
        [&](std::size_t i, std::size_t at) { result[at] = list[i]; });
    return result;
}

/// `sorted` with the families of `fresh`, all by parent. Each part of `sorted` takes what lies before the next part.
std::vector<Family> merged(const std::vector<Family>& sorted, const std::vector<Family>& fresh) {
    const auto before = [](const Family& a, const Family& b) { return a.parent < b.parent; };
    const Parts parts(sorted.size());
    const Grouped groups = grouped_in_order(fresh.size(), parts.count, [&](std::size_t i) {
        std::size_t part = 0;
        while (part + 1 < parts.count && !before(fresh[i], sorted[parts.begin(part + 1)])) ++part;
        return part;
    });
    std::vector<Family> result(sorted.size() + fresh.size());
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t p = 0; p < parts.count; ++p) {
        std::vector<Family> mine;
        for (std::size_t k = groups.first[p]; k < groups.first[p + 1]; ++k) mine.push_back(fresh[groups.item[k]]);
        std::sort(mine.begin(), mine.end(), before);
        std::merge(sorted.begin() + static_cast<std::ptrdiff_t>(parts.begin(p)),
                   sorted.begin() + static_cast<std::ptrdiff_t>(parts.end(p)), mine.begin(), mine.end(),
                   result.begin() + static_cast<std::ptrdiff_t>(parts.begin(p) + groups.first[p]), before);
    }
    return result;
}

}  // namespace

template <int Dim>
BlockIndex<Dim> grown(const BlockIndex<Dim>& index, const DomainBlocks<Dim>& domain, Reach reach) {
    std::vector<Family> families = index.families();
    const std::vector<Family> fresh = unique_of(add_reached(families, index, domain, reach));
    return BlockIndex<Dim>(merged(families, fresh));
}

template BlockIndex<2> grown<2>(const BlockIndex<2>&, const DomainBlocks<2>&, Reach);
template BlockIndex<3> grown<3>(const BlockIndex<3>&, const DomainBlocks<3>&, Reach);

}  // namespace moraine
