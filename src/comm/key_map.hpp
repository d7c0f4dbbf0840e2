#pragma once
// Index of a block by its key: open addressing in one flat table, about one cache miss per question. Binary search in
// the sorted keys costs ten; an epoch of 33 000 blocks asks 1.5 million times, between two steps of a device.

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "core/morton.hpp"

namespace moraine {

class KeyMap {
  public:
    KeyMap() = default;
    /// keys[i] -> i; no key twice.
    explicit KeyMap(std::span<const Key> keys)
        : mask_(std::bit_ceil(2 * keys.size() + 2) - 1), entries_(mask_ + 1, Entry{0, -1}) {
        for (std::size_t i = 0; i < keys.size(); ++i) {
            std::size_t at = start(keys[i]);
            while (entries_[at].index >= 0) at = (at + 1) & mask_;
            entries_[at] = {keys[i], static_cast<std::int32_t>(i)};
        }
    }

    /// Index of the key, or -1.
    std::int32_t find(Key key) const {
        for (std::size_t at = start(key); entries_[at].index >= 0; at = (at + 1) & mask_)
            if (entries_[at].key == key) return entries_[at].index;
        return -1;
    }

  private:
    struct Entry {
        Key key;
        std::int32_t index;
    };

    /// Fibonacci hashing: neighbouring keys, which differ in their low bits, are spread.
    std::size_t start(Key key) const { return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ull) >> 32) & mask_; }

    std::size_t mask_ = 0;
    std::vector<Entry> entries_{Entry{0, -1}};
};

}  // namespace moraine
