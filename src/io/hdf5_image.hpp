#pragma once
// The few structures of the HDF5 file format that our files need, as bytes in memory.
//
// Why not let the HDF5 library write: it changes its metadata in place, so a program killed between two
// of its writes leaves a time series that nobody can open; and version 1.10 crashes at exit once the
// disk was full. Here all metadata is made in memory, written behind the rows, and becomes valid when
// the superblock (48 bytes at the start, one write) points to it: a switch that happens or does not.
//
// Format: "HDF5 File Format Specification Version 2.0" (The HDF Group), sections II.A superblock
// version 2, III.A.1 B-tree version 1, IV.A.1.b object header version 2, IV.A.2 messages. Readable by
// the library from 1.8 on; our own files are read with it.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/columns.hpp"

namespace moraine::hdf5 {

using Address = std::uint64_t;  ///< in the file [byte]
inline constexpr Address nowhere = ~Address(0);
inline constexpr std::size_t superblock_bytes = 48;

/// Numbers in little-endian order.
class Bytes {
  public:
    Bytes& number(std::uint64_t value, int width);
    Bytes& raw(const void* data, std::size_t size);
    Bytes& text(std::string_view text) { return raw(text.data(), text.size()); }
    Bytes& zeros(std::size_t size);

    std::size_t size() const { return bytes_.size(); }
    const std::vector<std::byte>& get() const { return bytes_; }

  private:
    std::vector<std::byte> bytes_;
};

/// Type of the elements of a dataset or attribute.
struct ElementType {
    enum class Kind { unsigned_integer, signed_integer, real, text };
    Kind kind = Kind::signed_integer;
    int bytes = 8;

    static ElementType of(Column::Type type);
};

/// Where the elements of a dataset are: one piece, or chunks of rows.
struct Storage {
    Address at = nowhere;         ///< of the piece, or of the root of the tree of chunks
    std::int64_t chunk_rows = 0;  ///< 0: one piece
    bool filtered = false;        ///< chunks pass the filters of io/deflate.hpp, but for those that say otherwise
};

struct Attribute {
    std::string name;
    ElementType type;
    std::int64_t count = 0;  ///< 0: a scalar
    std::vector<std::byte> value;
};

Attribute text_attribute(std::string name, std::string_view text);
Attribute integer_attribute(std::string name, std::span<const std::int64_t> values, bool scalar);

using Links = std::vector<std::pair<std::string, Address>>;

/// `links`: how many links point to the object.
std::vector<std::byte> group(const Links& members, const std::vector<Attribute>& attributes, int links = 1);

/// extent: rows, then components if there are several. Missing chunks read as NaN, or 0 of integers.
std::vector<std::byte> dataset(const ElementType& type, const std::vector<std::int64_t>& extent, const Storage& storage,
                               const std::vector<Attribute>& attributes, int links = 1);

/// Pieces of metadata one after the other, on multiples of 8 bytes, to be written at `at`.
class Region {
  public:
    explicit Region(Address at) : at_(at) {}

    Address put(const std::vector<std::byte>& piece);

    /// A dataset and its values.
    Address put_values(const ElementType& type, const std::vector<std::int64_t>& extent, const void* values,
                       int links = 1);
    template <class T>
    Address put_list(const std::vector<T>& list, const std::vector<std::int64_t>& extent, int links = 1) {
        using Kind = ElementType::Kind;
        const Kind kind = std::is_floating_point_v<T> ? Kind::real
                          : std::is_signed_v<T>       ? Kind::signed_integer
                                                      : Kind::unsigned_integer;
        return put_values({kind, sizeof(T)}, extent, list.data(), links);
    }

    Address end() const { return at_ + bytes_.size(); }
    const std::vector<std::byte>& get() const { return bytes_.get(); }

  private:
    Address at_;
    Bytes bytes_;
};

/// A chunk begins at row `index * chunk_rows`.
struct Chunk {
    std::int64_t index = 0;
    Address at = nowhere;
    std::int64_t bytes = 0;  ///< in the file, once filtered; 0: those of its rows
};

/// What the nodes of a chunk tree need to know of their dataset.
struct ChunkShape {
    std::int64_t rows = 0;  ///< of a chunk
    int components = 1;
    int row_bytes = 8;
    bool filtered = false;  ///< chunks that tell no bytes were left out by the filters of the dataset
};

inline constexpr std::size_t node_entries = 64;  ///< 2 K, K = 32: the library's default

/// One node: children in ascending order, for level 0 chunks, above it nodes by their first chunk.
std::vector<std::byte> chunk_node(const ChunkShape& shape, int level, std::span<const Chunk> children,
                                  std::int64_t end_index);

std::vector<std::byte> superblock(Address root, Address end_of_file);

/// End of file that a superblock names; `nowhere` if these bytes are none.
Address end_of_file(std::span<const std::byte> superblock_bytes);

}  // namespace moraine::hdf5
