#pragma once
// What the writer and the reader of checkpoints agree on: the types of columns, and the seal.
//
// The seal stands behind the end of the HDF5 file (readers of HDF5 ignore it) and covers every byte that
// is not a particle's: where the rows are, FNV-1a of all the rest, and of the seal itself. It is checked
// before the HDF5 library sees the file, so that damaged metadata never reaches it.
// Cut, torn or flipped files are thus known without it.

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <vector>

#include "io/columns.hpp"

namespace moraine::checkpoint {

inline constexpr std::int64_t format_version = 1;

/// Bytes of the file that hold rows.
struct Region {
    std::int64_t at = 0;
    std::int64_t bytes = 0;
};

/// Appends the seal to the file at `path`. Throws MachineError. Not collective.
void seal(const std::string& path, std::vector<Region> rows);

/// Throws std::runtime_error, with the reason, if the file is not what was sealed. Not collective.
void check_seal(const std::string& path);

/// Type of a column in the file, little-endian.
hid_t file_type(Column::Type type);

}  // namespace moraine::checkpoint
