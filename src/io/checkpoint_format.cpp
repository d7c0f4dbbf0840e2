#include "io/checkpoint_format.hpp"

#include <fmt/format.h>

namespace moraine {

std::string checkpoint_name(std::int64_t step) {
    return fmt::format("checkpoint-{:09}.h5", step);
}

namespace checkpoint {

namespace {

class Fnv {
  public:
    void add(const void* data, std::size_t bytes) {
        for (std::size_t i = 0; i < bytes; ++i) {
            hash_ ^= static_cast<const unsigned char*>(data)[i];
            hash_ *= 0x100000001b3ULL;
        }
    }
    void add(std::int64_t value) { add(&value, sizeof value); }
    void add(double value) { add(&value, sizeof value); }
    template <class List>
    void add(const List& list) {
        add(static_cast<std::int64_t>(list.size()));
        add(list.data(), list.size() * sizeof list[0]);
    }
    std::uint64_t value() const { return hash_; }

  private:
    std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

}  // namespace

std::uint64_t checksum(const CheckpointHeader& header, std::span<const BlockRow> blocks) {
    Fnv hash;
    for (const auto& [key, value] : header) {
        hash.add(key);
        hash.add(static_cast<std::int64_t>(value.index()));
        std::visit([&](const auto& v) { hash.add(v); }, value);
    }
    hash.add(blocks);
    return hash.value();
}

hid_t file_type(Column::Type type) {
    switch (type) {
        case Column::Type::u8:
            return H5T_STD_U8LE;
        case Column::Type::u16:
            return H5T_STD_U16LE;
        case Column::Type::u32:
            return H5T_STD_U32LE;
        case Column::Type::u64:
            return H5T_STD_U64LE;
        case Column::Type::f32:
            return H5T_IEEE_F32LE;
        default:
            return H5T_IEEE_F64LE;
    }
}

}  // namespace checkpoint

}  // namespace moraine
