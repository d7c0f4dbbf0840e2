#pragma once
// From the rows of a rank to the rows of a file, and back.
//
// In a file the blocks follow each other in key order, whoever owned them. Ownership may be any table,
// so a rank's rows are many short runs of the file. Instead of a file selection of many runs, the bytes
// are first sent to the ranks by file position: rank r then holds rows [r n / P, (r + 1) n / P) and
// writes or reads them in one piece.
// Invariant: a rank's ranges ascend; ranges of different ranks may meet (reading) but their rows in
// the sending direction do not.

#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"
#include "io/columns.hpp"

namespace moraine {

/// Which rows of a file are whose: ranges, rank by rank, and how many each rank has.
struct RankRanges {
    std::vector<RowRange> ranges;
    std::vector<std::int64_t> counts;
};

/// All blocks in key order, and where they are in the file.
struct FileOrder {
    std::vector<BlockRow> blocks;
    RankRanges of_ranks;
    std::int64_t rows = 0;
};

/// My blocks ascend by key; no key is given twice. Collective.
FileOrder file_order(const Comm& comm, std::span<const BlockRow> my_blocks);

/// Columns that travel together, one exchange a group: as many in a row as are not wider than the widest of all, so
/// that they need no more memory at a time than it does.
std::vector<std::span<const Column>> column_groups(std::span<const Column> columns);

/// Rows of the file that a rank writes or reads: multiples of `grain`, and the end.
RowRange slice_of(std::int64_t rows, std::int64_t grain, int rank, int ranks);

class RowOrder {
  public:
    /// Where every rank knows what all have; slices are whole multiples of `grain` rows. Not collective.
    RowOrder(const Comm& comm, const RankRanges& all, std::int64_t file_rows, std::int64_t grain = 1);
    /// Collective.
    RowOrder(const Comm& comm, std::span<const RowRange> mine, std::int64_t file_rows);

    /// The rows of the file that this rank writes or reads.
    RowRange slice() const { return slice_; }

    /// My rows of some columns, in the order of my ranges, to the slices of each; one exchange. Collective.
    std::vector<std::vector<std::byte>> to_file(std::span<const Column> columns) const;

    /// The slice to my rows. Collective.
    void from_file(const std::byte* slice, int row_bytes, std::byte* rows) const;

  private:
    void count_mine(std::span<const RowRange> mine, std::int64_t file_rows);
    void pack(const Column& column, std::size_t before, std::size_t width, std::byte* message) const;

    struct Run {
        int rank = 0;             ///< whose
        std::int64_t at = 0;      ///< first row within the slice
        std::int64_t packed = 0;  ///< first row within what the ranks send, rank by rank
        std::int64_t count = 0;
    };

    const Comm& comm_;
    std::int64_t grain_;
    RowRange slice_;
    std::vector<Run> runs_;                ///< of all ranks' ranges in my slice
    std::vector<int> my_count_, my_at_;    ///< my rows by the rank that has their slice
    std::vector<int> all_count_, all_at_;  ///< rows of my slice by the rank whose they are
    std::int64_t packed_rows_ = 0;
};

}  // namespace moraine
