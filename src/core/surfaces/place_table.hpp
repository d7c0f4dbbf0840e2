#pragma once
// Values by place, found when they are first asked for. Places that are asked for one after the other are neighbours:
// they are kept in blocks of 4^d, and the blocks that were used last are at hand without a search.

#include <cstdint>
#include <memory>
#include <unordered_map>

#include "core/data/block.hpp"
#include "core/data/vec.hpp"

namespace moraine {

template <class T, int Dim>
class PlaceTable {
  public:
    using Place = Vec<std::int32_t, Dim>;

    /// Of a place; find(): what it is, the first time. find() may not ask this table. Stays where it is.
    template <class Find>
    const T& at(const Place& place, const Find& find) {
        Group& group = group_of(place);
        int k = 0;
        for (int a = 0; a < Dim; ++a) k |= (place[a] & 3) << (2 * a);
        const std::uint64_t bit = std::uint64_t{1} << k;
        if (!(group.known & bit)) group.value[k] = find(), group.known |= bit;
        return group.value[k];
    }
    void forget() {
        groups_.clear();
        for (Recent& r : recent_) r.group = nullptr;
    }

  private:
    struct Group {
        std::uint64_t known = 0;  ///< by place
        T value[Block<Dim>::cells];
    };
    struct Recent {
        Place place{};
        Group* group = nullptr;
    };
    struct Hash {
        std::size_t operator()(const Place& p) const {
            std::uint64_t h = 0;
            for (int a = 0; a < Dim; ++a) h = (h ^ static_cast<std::uint32_t>(p[a])) * 0x9E3779B97F4A7C15ull;
            return static_cast<std::size_t>(h ^ h >> 29);
        }
    };
    struct Same {
        bool operator()(const Place& p, const Place& q) const {
            for (int a = 0; a < Dim; ++a)
                if (p[a] != q[a]) return false;
            return true;
        }
    };

    Group& group_of(const Place& place) {
        Place of;
        int k = 0;
        for (int a = 0; a < Dim; ++a) of[a] = place[a] >> 2, k |= (of[a] & 3) << (2 * a);
        Recent& recent = recent_[k];
        if (!recent.group || !Same{}(recent.place, of)) {
            std::unique_ptr<Group>& kept = groups_[of];
            if (!kept) kept = std::make_unique<Group>();
            recent = {of, kept.get()};
        }
        return *recent.group;
    }

    std::unordered_map<Place, std::unique_ptr<Group>, Hash, Same> groups_;
    Recent recent_[Block<Dim>::cells];  ///< by the last bits of their places
};

}  // namespace moraine
