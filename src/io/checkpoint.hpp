#pragma once
// A checkpoint: everything needed to go on, on any number of ranks. One HDF5 file:
//
//   /header/<key>            what the run knows: numbers, text, short lists
//   /blocks/key, /count      blocks in key order
//   /particles/<column>      rows in key order of blocks, list order within a block
//   a seal                   checksum of all but the rows (checkpoint_format.hpp)
//
// The bytes do not depend on the ranks that wrote it. The rows are covered by the caller's state hash,
// kept in the header and recomputed at load.
// Rank 0 lays the file out (hdf5_image.hpp), then every rank writes its slice of each column at its place
// (disk_file.hpp says why not MPI-IO). The file has a temporary name until all of it is on the disk.

#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "io/row_order.hpp"

namespace moraine {

using HeaderValue = std::variant<std::int64_t, double, std::string, std::vector<std::int64_t>, std::vector<double>>;
using CheckpointHeader = std::map<std::string, HeaderValue>;

/// "checkpoint-000000120.h5"
std::string checkpoint_name(std::int64_t step);

/// My blocks ascend by key; the rows of `columns` are theirs, in the same order, and every rank names
/// the same columns. Throws MachineError on all ranks if one cannot write; no file is left then.
/// Collective.
void write_checkpoint(const Comm& comm, const std::string& path, const CheckpointHeader& header,
                      std::span<const BlockRow> my_blocks, std::span<const Column> columns);

/// Every member that can fail throws InputError, the same on all ranks.
class CheckpointReader {
  public:
    /// Reads all but the rows. Collective.
    CheckpointReader(const Comm& comm, const std::string& path);

    const CheckpointHeader& header() const { return header_; }

    /// Not collective: the header is the same on all ranks.
    template <class T>
    const T& get(const std::string& key) const {
        const auto found = header_.find(key);
        const T* value = found == header_.end() ? nullptr : std::get_if<T>(&found->second);
        if (!value) missing("header/" + key);
        return *value;
    }

    /// In key order; block k begins at row starts()[k]; starts() ends with the number of rows.
    const std::vector<BlockRow>& blocks() const { return blocks_; }
    const std::vector<std::int64_t>& starts() const { return starts_; }

    /// Shapes of the columns in the file (no data), by name.
    const std::vector<Column>& columns() const { return columns_; }

    /// Rows `mine` of a column, which must have this type and number of components, into `rows`.
    /// Ranges ascend. Collective.
    void read_rows(const Column& shape, std::span<const RowRange> mine, std::byte* rows) const;

    /// Throws InputError that names the file. What the file holds is the same on all ranks, so this is.
    [[noreturn]] void refuse(const std::string& why) const;

  private:
    void read_tables();
    [[noreturn]] void missing(const std::string& what) const;

    const Comm& comm_;
    std::string path_;
    CheckpointHeader header_;
    std::vector<BlockRow> blocks_;
    std::vector<std::int64_t> starts_;
    std::vector<Column> columns_;
};

}  // namespace moraine
