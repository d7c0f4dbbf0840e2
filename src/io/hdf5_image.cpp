#include "io/hdf5_image.hpp"

#include <bit>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "io/deflate.hpp"

namespace moraine::hdf5 {

namespace {

constexpr char signature[] = "\x89HDF\r\n\x1a\n";

/// Bob Jenkins' lookup3 over bytes (public domain): the format's metadata checksum.
std::uint32_t lookup3(std::span<const std::byte> data) {
    std::uint32_t a = 0xdeadbeefU + static_cast<std::uint32_t>(data.size());
    std::uint32_t b = a;
    std::uint32_t c = a;
    const auto add = [&](std::size_t from, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            std::uint32_t& word = i < 4 ? a : i < 8 ? b : c;
            word += std::to_integer<std::uint32_t>(data[from + i]) << (8 * (i % 4));
        }
    };
    const auto turn = [](std::uint32_t& x, std::uint32_t& y, std::uint32_t& z, int bits) {  // x, z; y grows
        x -= z;
        x ^= std::rotl(z, bits);
        z += y;
    };
    std::size_t at = 0;
    for (; data.size() - at > 12; at += 12) {
        add(at, 12);
        turn(a, b, c, 4);
        turn(b, c, a, 6);
        turn(c, a, b, 8);
        turn(a, b, c, 16);
        turn(b, c, a, 19);
        turn(c, a, b, 4);
    }
    if (at == data.size()) return c;
    add(at, data.size() - at);
    const auto close = [](std::uint32_t& x, std::uint32_t y, int bits) {
        x ^= y;
        x -= std::rotl(y, bits);
    };
    close(c, b, 14);
    close(a, c, 11);
    close(b, a, 25);
    close(c, b, 16);
    close(a, c, 4);
    close(b, a, 14);
    close(c, b, 24);
    return c;
}

enum MessageType {
    dataspace_message = 1,
    link_info = 2,
    datatype_message = 3,
    fill_value = 5,
    link = 6,
    layout = 8,
    group_info = 10,
    filter_pipeline = 11,
    attribute_message = 12,
    reference_count = 22
};

Bytes datatype(const ElementType& type) {
    using Kind = ElementType::Kind;
    Bytes b;
    if (type.kind == Kind::text) return b.number(0x13, 1).number(0x01, 3).number(type.bytes, 4);  // padded with NUL
    if (type.kind != Kind::real)
        return b.number(0x10, 1)
            .number(type.kind == Kind::signed_integer ? 0x08 : 0, 3)
            .number(type.bytes, 4)
            .number(0, 2)
            .number(8 * type.bytes, 2);
    const bool wide = type.bytes == 8;
    b.number(0x11, 1).number(0x20, 1).number(wide ? 63 : 31, 1).number(0, 1).number(type.bytes, 4);
    b.number(0, 2).number(8 * type.bytes, 2).number(wide ? 52 : 23, 1).number(wide ? 11 : 8, 1);
    return b.number(0, 1).number(wide ? 52 : 23, 1).number(wide ? 1023 : 127, 4);
}

/// `open_ended`: rows may grow (the format asks that of nothing, readers of chunks like it).
Bytes dataspace(const std::vector<std::int64_t>& extent, bool open_ended) {
    Bytes b;
    b.number(2, 1).number(extent.size(), 1).number(open_ended ? 1 : 0, 1).number(extent.empty() ? 0 : 1, 1);
    for (const std::int64_t n : extent) b.number(static_cast<std::uint64_t>(n), 8);
    if (open_ended)
        for (std::size_t d = 0; d < extent.size(); ++d)
            b.number(d == 0 ? ~std::uint64_t(0) : static_cast<std::uint64_t>(extent[d]), 8);
    return b;
}

Bytes nan_or_zero(const ElementType& type) {
    Bytes b;
    if (type.kind != ElementType::Kind::real) return b.zeros(static_cast<std::size_t>(type.bytes));
    const float single = std::numeric_limits<float>::quiet_NaN();
    const double wide = std::numeric_limits<double>::quiet_NaN();
    return type.bytes == 4 ? b.raw(&single, 4) : b.raw(&wide, 8);
}

/// Byte shuffle, then deflate (io/deflate.hpp): numbers 2 and 1 of the library.
Bytes filters(const ElementType& type) {
    Bytes b;
    b.number(2, 1).number(2, 1);
    b.number(2, 2).number(1, 2).number(1, 2).number(static_cast<std::uint64_t>(type.bytes), 4);
    return b.number(1, 2).number(1, 2).number(1, 2).number(deflate_level, 4);
}
constexpr int number_of_filters = 2;

/// An object: its messages between a prefix and a checksum.
class Header {
  public:
    void message(MessageType type, const Bytes& content) {
        body_.number(type, 1).number(content.size(), 2).number(0, 1).raw(content.get().data(), content.size());
    }
    void attributes(const std::vector<Attribute>& list) {
        for (const Attribute& a : list) {
            const Bytes type = datatype(a.type);
            const Bytes space = dataspace(a.count == 0 ? std::vector<std::int64_t>{} : std::vector{a.count}, false);
            Bytes b;
            b.number(3, 1).number(0, 1).number(a.name.size() + 1, 2).number(type.size(), 2).number(space.size(), 2);
            b.number(0, 1).text(a.name).zeros(1).raw(type.get().data(), type.size());
            b.raw(space.get().data(), space.size()).raw(a.value.data(), a.value.size());
            message(attribute_message, b);
        }
    }
    std::vector<std::byte> finish(int links) {
        if (links > 1) message(reference_count, Bytes().zeros(1).number(links, 4));
        Bytes b;
        b.text("OHDR").number(2, 1).number(2, 1).number(body_.size(), 4).raw(body_.get().data(), body_.size());
        return b.number(lookup3(b.get()), 4).get();
    }

  private:
    Bytes body_;
};

}  // namespace

Bytes& Bytes::number(std::uint64_t value, int width) {
    for (int i = 0; i < width; ++i) bytes_.push_back(static_cast<std::byte>(value >> (8 * i)));
    return *this;
}

Bytes& Bytes::raw(const void* data, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
    return *this;
}

Bytes& Bytes::zeros(std::size_t size) {
    bytes_.resize(bytes_.size() + size);
    return *this;
}

ElementType ElementType::of(Column::Type type) {
    return {Column::is_float(type) ? Kind::real : Kind::unsigned_integer, Column::bytes_of(type)};
}

Attribute text_attribute(std::string name, std::string_view text) {
    Bytes value;
    value.text(text).zeros(text.empty() ? 1 : 0);
    return {std::move(name), {ElementType::Kind::text, static_cast<int>(value.size())}, 0, value.get()};
}

Attribute integer_attribute(std::string name, std::span<const std::int64_t> values, bool scalar) {
    Bytes bytes;
    for (const std::int64_t v : values) bytes.number(static_cast<std::uint64_t>(v), 8);
    return {std::move(name), {}, scalar ? 0 : static_cast<std::int64_t>(values.size()), bytes.get()};
}

std::vector<std::byte> group(const Links& members, const std::vector<Attribute>& attributes, int links) {
    Header header;
    header.message(link_info, Bytes().zeros(2).number(nowhere, 8).number(nowhere, 8));
    header.message(group_info, Bytes().zeros(2));
    for (const auto& [name, at] : members) {
        if (name.size() > 255) throw std::length_error("a link's name has " + std::to_string(name.size()) + " bytes");
        header.message(link, Bytes().number(1, 1).number(0, 1).number(name.size(), 1).text(name).number(at, 8));
    }
    header.attributes(attributes);
    return header.finish(links);
}

std::vector<std::byte> dataset(const ElementType& type, const std::vector<std::int64_t>& extent, const Storage& storage,
                               const std::vector<Attribute>& attributes, int links) {
    const bool chunked = storage.chunk_rows > 0;
    Header header;
    header.message(dataspace_message, dataspace(extent, chunked));
    header.message(datatype_message, datatype(type));
    Bytes fill;
    fill.number(3, 1).number(chunked ? 0x2b : 0x0a, 1);
    if (chunked) {
        const Bytes value = nan_or_zero(type);
        fill.number(value.size(), 4).raw(value.get().data(), value.size());
    }
    header.message(fill_value, fill);
    Bytes where;
    where.number(3, 1).number(chunked ? 2 : 1, 1);
    if (chunked) {
        where.number(extent.size() + 1, 1).number(storage.at, 8).number(storage.chunk_rows, 4);
        for (std::size_t d = 1; d < extent.size(); ++d) where.number(extent[d], 4);
        where.number(type.bytes, 4);
    } else {
        std::uint64_t bytes = type.bytes;
        for (const std::int64_t n : extent) bytes *= static_cast<std::uint64_t>(n);
        where.number(bytes > 0 ? storage.at : nowhere, 8).number(bytes, 8);
    }
    header.message(layout, where);
    if (storage.filtered) header.message(filter_pipeline, filters(type));
    header.attributes(attributes);
    return header.finish(links);
}

Address Region::put(const std::vector<std::byte>& piece) {
    bytes_.zeros((8 - bytes_.size() % 8) % 8);
    const Address here = end();
    bytes_.raw(piece.data(), piece.size());
    return here;
}

Address Region::put_values(const ElementType& type, const std::vector<std::int64_t>& extent, const void* values,
                           int links) {
    std::size_t size = static_cast<std::size_t>(type.bytes);
    for (const std::int64_t n : extent) size *= static_cast<std::size_t>(n);
    const Address at = put(Bytes().raw(values, size).get());
    return put(dataset(type, extent, {at, 0}, {}, links));
}

std::vector<std::byte> chunk_node(const ChunkShape& shape, int level, std::span<const Chunk> children,
                                  std::int64_t end_index) {
    Bytes b;
    b.text("TREE").number(1, 1).number(level, 1).number(children.size(), 2).number(nowhere, 8).number(nowhere, 8);
    const auto key = [&](const Chunk& c) {
        const bool left_out = shape.filtered && c.bytes == 0;
        b.number(static_cast<std::uint64_t>(c.bytes > 0 ? c.bytes : shape.rows * shape.row_bytes), 4);
        b.number(left_out ? (1U << number_of_filters) - 1 : 0, 4);
        b.number(static_cast<std::uint64_t>(c.index * shape.rows), 8).zeros(shape.components > 1 ? 16 : 8);
    };
    for (const Chunk& child : children) {
        key(child);
        b.number(child.at, 8);
    }
    key({end_index});
    const std::size_t key_bytes = shape.components > 1 ? 32 : 24;
    const std::size_t full = 24 + node_entries * 8 + (node_entries + 1) * key_bytes;
    return b.zeros(full - b.size()).get();
}

std::vector<std::byte> superblock(Address root, Address end_of_file) {
    Bytes b;
    b.text({signature, 8}).number(2, 1).number(8, 1).number(8, 1).number(0, 1);
    b.number(0, 8).number(nowhere, 8).number(end_of_file, 8).number(root, 8);
    return b.number(lookup3(b.get()), 4).get();
}

Address end_of_file(std::span<const std::byte> bytes) {
    if (bytes.size() < superblock_bytes || std::memcmp(bytes.data(), signature, 8) != 0) return nowhere;
    Address end = 0;
    for (std::size_t i = 0; i < 8; ++i) end |= std::to_integer<Address>(bytes[28 + i]) << (8 * i);
    return end;
}

}  // namespace moraine::hdf5
