#pragma once
// Values by place, found when they are first asked for, by threads together. Places that are asked for one after the
// other are neighbours: they are kept in blocks of 4^d, and the blocks that a thread used last are at hand without a
// search.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "core/data/block.hpp"
#include "core/data/vec.hpp"

namespace moraine {

/// What all threads have found.
template <class T, int Dim>
class PlaceStore {
  public:
    using Place = Vec<std::int32_t, Dim>;
    struct Group {
        std::atomic<std::uint64_t> known = 0;  ///< by place
        T value[Block<Dim>::cells];
    };

    Group& group_at(const Place& of) {
        const std::lock_guard hold(mutex_);
        std::unique_ptr<Group>& kept = groups_[of];
        if (!kept) kept = std::make_unique<Group>();
        return *kept;
    }
    /// Who comes second finds what is there, which is the same.
    void put(Group& group, int k, const T& value) {
        const std::uint64_t bit = std::uint64_t{1} << k;
        const std::lock_guard hold(mutex_);
        if (group.known.load(std::memory_order_relaxed) & bit) return;
        group.value[k] = value;
        group.known.fetch_or(bit, std::memory_order_release);
    }
    /// By one thread.
    void forget() { groups_.clear(); }

  private:
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

    std::mutex mutex_;
    std::unordered_map<Place, std::unique_ptr<Group>, Hash, Same> groups_;
};

/// A thread's way to it.
template <class T, int Dim>
class PlaceTable {
  public:
    using Place = Vec<std::int32_t, Dim>;

    explicit PlaceTable(PlaceStore<T, Dim>& store) : store_(&store) {}
    /// Of a place; find(): what it is, the first time. Stays where it is.
    template <class Find>
    const T& at(const Place& place, const Find& find) {
        Group& group = group_of(place);
        int k = 0;
        for (int a = 0; a < Dim; ++a) k |= (place[a] & 3) << (2 * a);
        const std::uint64_t bit = std::uint64_t{1} << k;
        if (!(group.known.load(std::memory_order_acquire) & bit)) store_->put(group, k, find());
        return group.value[k];
    }
    /// The store has forgotten.
    void forget() {
        for (Recent& r : recent_) r.group = nullptr;
    }

  private:
    using Group = typename PlaceStore<T, Dim>::Group;
    struct Recent {
        Place place{};
        Group* group = nullptr;
    };

    Group& group_of(const Place& place) {
        Place of;
        int k = 0;
        for (int a = 0; a < Dim; ++a) of[a] = place[a] >> 2, k |= (of[a] & 3) << (2 * a);
        Recent& recent = recent_[k];
        bool same = recent.group != nullptr;
        for (int a = 0; a < Dim; ++a) same = same && recent.place[a] == of[a];
        if (!same) recent = {of, &store_->group_at(of)};
        return *recent.group;
    }

    PlaceStore<T, Dim>* store_;
    Recent recent_[Block<Dim>::cells];  ///< by the last bits of their places
};

}  // namespace moraine
