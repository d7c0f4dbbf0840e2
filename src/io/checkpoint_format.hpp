#pragma once
// What the writer and the reader of checkpoints agree on.

#include <hdf5.h>

#include <cstdint>
#include <span>

#include "io/checkpoint.hpp"

namespace moraine::checkpoint {

inline constexpr std::int64_t format_version = 1;

/// 64-bit FNV-1a of all keys, types and values, then of the blocks. One changed bit changes it.
std::uint64_t checksum(const CheckpointHeader& header, std::span<const BlockRow> blocks);

/// Type of a column in the file, little-endian.
hid_t file_type(Column::Type type);

}  // namespace moraine::checkpoint
