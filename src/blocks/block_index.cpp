#include "blocks/block_index.hpp"

#include <atomic>

#include "blocks/in_order.hpp"

namespace moraine {

std::int32_t FamilyTable::insert(std::span<const Family> list, std::int32_t place) {
    const Key parent = list[static_cast<std::size_t>(place)].parent;
    for (std::size_t at = start(parent);; at = (at + 1) & mask_) {
        std::int32_t there = -1;
        if (std::atomic_ref(place_[at]).compare_exchange_strong(there, place, std::memory_order_relaxed)) return place;
        if (list[static_cast<std::size_t>(there)].parent == parent) return there;
    }
}

template <int Dim>
BlockIndex<Dim>::BlockIndex(std::span<const Key> keys) {
    const auto begins = [&](std::size_t i) { return i == 0 || keys[i] >> Dim != keys[i - 1] >> Dim; };
    place_in_order(
        keys.size(), begins, [&](std::size_t size) { families_.resize(size); },
        [&](std::size_t i, std::size_t at) {
            Family family{keys[i] >> Dim, static_cast<std::int32_t>(i), 0};
            for (; i < keys.size() && keys[i] >> Dim == family.parent; ++i)
                family.mask |= 1u << (keys[i] & (children - 1));
            families_[at] = family;
        });
    insert_families();
}

template <int Dim>
BlockIndex<Dim>::BlockIndex(std::vector<Family> families) : families_(std::move(families)) {
    place_in_order(
        families_.size(), [&](std::size_t f) { return std::popcount(families_[f].mask); }, [](std::size_t) {},
        [&](std::size_t f, std::size_t at) { families_[f].first = static_cast<std::int32_t>(at); });
    insert_families();
}

template <int Dim>
void BlockIndex<Dim>::insert_families() {
    table_ = FamilyTable(families_.size());
#pragma omp parallel for schedule(static)
    for (std::size_t f = 0; f < families_.size(); ++f) table_.insert(families_, static_cast<std::int32_t>(f));
}

template <int Dim>
std::vector<Key> BlockIndex<Dim>::keys() const {
    if (families_.empty()) return {};
    const Family& last = families_.back();
    std::vector<Key> keys(static_cast<std::size_t>(last.index_of(children)));
#pragma omp parallel for schedule(static)
    for (std::size_t f = 0; f < families_.size(); ++f) {
        auto at = static_cast<std::size_t>(families_[f].first);
        for (unsigned child = 0; child < children; ++child)
            if (families_[f].has(child)) keys[at++] = (families_[f].parent << Dim) + child;
    }
    return keys;
}

template class BlockIndex<2>;
template class BlockIndex<3>;

}  // namespace moraine
