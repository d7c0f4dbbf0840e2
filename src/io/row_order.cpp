#include "io/row_order.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace moraine {

namespace {

RowRange common(const RowRange& a, const RowRange& b) {
    const std::int64_t begin = std::max(a.start, b.start);
    const std::int64_t end = std::min(a.start + a.count, b.start + b.count);
    return {begin, std::max<std::int64_t>(0, end - begin)};
}

int checked(std::int64_t rows) {
    if (rows > std::numeric_limits<int>::max()) throw std::length_error("more than 2^31 particles on a rank");
    return static_cast<int>(rows);
}

std::vector<int> starts_of(const std::vector<int>& counts) {
    std::vector<int> at(counts.size(), 0);
    for (std::size_t r = 1; r < counts.size(); ++r) at[r] = checked(std::int64_t(at[r - 1]) + counts[r - 1]);
    return at;
}

RankRanges gathered(const Comm& comm, std::span<const RowRange> mine) {
    RankRanges all;
    all.ranges = comm.all_gather(std::vector<RowRange>(mine.begin(), mine.end()), &all.counts);
    return all;
}

/// A row as one element: counts and offsets of messages stay below 2^31 where bytes would not.
class RowType {
  public:
    explicit RowType(int bytes) {
        MPI_Type_contiguous(bytes, MPI_BYTE, &type_);
        MPI_Type_commit(&type_);
    }
    ~RowType() { MPI_Type_free(&type_); }
    RowType(const RowType&) = delete;
    RowType& operator=(const RowType&) = delete;
    MPI_Datatype get() const { return type_; }

  private:
    MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

}  // namespace

RowRange slice_of(std::int64_t rows, std::int64_t grain, int rank, int ranks) {
    const std::int64_t grains = (rows + grain - 1) / grain;
    const auto start = [&](int r) {
        return std::min(rows, grain * (grains / ranks * r + std::min<std::int64_t>(r, grains % ranks)));
    };
    return {start(rank), start(rank + 1) - start(rank)};
}

FileOrder file_order(const Comm& comm, std::span<const BlockRow> my_blocks) {
    struct Owned {
        BlockRow block;
        std::size_t at;  ///< in the ranks' order
    };
    FileOrder order;
    const auto all = comm.all_gather(std::vector<BlockRow>(my_blocks.begin(), my_blocks.end()), &order.of_ranks.counts);
    std::vector<Owned> sorted;
    for (std::size_t k = 0; k < all.size(); ++k) sorted.push_back({all[k], k});
    std::sort(sorted.begin(), sorted.end(), [](const Owned& a, const Owned& b) { return a.block.key < b.block.key; });
    order.of_ranks.ranges.resize(all.size());
    for (const Owned& owned : sorted) {
        order.blocks.push_back(owned.block);
        order.of_ranks.ranges[owned.at] = {order.rows, owned.block.count};
        order.rows += owned.block.count;
    }
    return order;
}

std::vector<std::span<const Column>> column_groups(std::span<const Column> columns) {
    int widest = 0;
    for (const Column& column : columns) widest = std::max(widest, column.row_bytes());
    std::vector<std::span<const Column>> groups;
    for (std::size_t begin = 0, end = 0; begin < columns.size(); begin = end) {
        int bytes = 0;
        while (end < columns.size() && bytes + columns[end].row_bytes() <= widest) bytes += columns[end++].row_bytes();
        groups.push_back(columns.subspan(begin, end - begin));
    }
    return groups;
}

RowOrder::RowOrder(const Comm& comm, std::span<const RowRange> mine, std::int64_t file_rows)
    : RowOrder(comm, gathered(comm, mine), file_rows) {}

RowOrder::RowOrder(const Comm& comm, const RankRanges& all, std::int64_t file_rows, std::int64_t grain)
    : comm_(comm), grain_(grain), slice_(slice_of(file_rows, grain, comm.rank(), comm.size())) {
    const auto ranks = static_cast<std::size_t>(comm.size());
    my_count_.assign(ranks, 0);
    all_count_.assign(ranks, 0);
    auto range = all.ranges.begin();
    for (std::size_t r = 0; r < ranks; ++r) {
        const auto end = range + all.counts[r];
        if (static_cast<int>(r) == comm.rank()) count_mine({range, end}, file_rows);
        for (; range != end; ++range) {
            const RowRange here = common(*range, slice_);
            if (here.count == 0) continue;
            runs_.push_back({static_cast<int>(r), here.start - slice_.start, packed_rows_, here.count});
            all_count_[r] = checked(all_count_[r] + here.count);
            packed_rows_ += here.count;
        }
    }
    my_at_ = starts_of(my_count_);
    all_at_ = starts_of(all_count_);
}

/// How many of my rows go to the slice of each rank.
void RowOrder::count_mine(std::span<const RowRange> mine, std::int64_t file_rows) {
    int holder = 0;
    for (const RowRange& range : mine)
        for (std::int64_t left = range.count; left > 0;) {
            const std::int64_t at = range.start + range.count - left;
            RowRange slice = slice_of(file_rows, grain_, holder, comm_.size());
            while (holder + 1 < comm_.size() && at >= slice.start + slice.count)
                slice = slice_of(file_rows, grain_, ++holder, comm_.size());
            const std::int64_t here = common({at, left}, slice).count;
            if (here == 0) throw std::logic_error("ranges of rows descend or leave the file");
            int& count = my_count_[static_cast<std::size_t>(holder)];
            count = checked(count + here);
            left -= here;
        }
}

/// A column into messages whose rows have `width` bytes, `before` of them of the columns before it: the message to a
/// rank has its columns one after the other.
void RowOrder::pack(const Column& column, std::size_t before, std::size_t width, std::byte* message) const {
    const auto bytes = static_cast<std::size_t>(column.row_bytes());
    std::vector<std::byte> made;
    if (!column.data && column.make) {
        made.resize((static_cast<std::size_t>(my_at_.back()) + static_cast<std::size_t>(my_count_.back())) * bytes);
        column.make(made.data());
    }
    const std::byte* rows = column.data ? column.data : made.data();
    for (std::size_t r = 0; r < my_count_.size(); ++r) {
        const auto at = static_cast<std::size_t>(my_at_[r]), count = static_cast<std::size_t>(my_count_[r]);
        if (count > 0) std::memcpy(message + at * width + before * count, rows + at * bytes, count * bytes);
    }
}

std::vector<std::vector<std::byte>> RowOrder::to_file(std::span<const Column> columns) const {
    std::vector<std::vector<std::byte>> slices(columns.size());
    const auto my_rows = static_cast<std::size_t>(my_at_.back()) + static_cast<std::size_t>(my_count_.back());
    for (std::size_t c = 0; c < columns.size() && comm_.size() == 1; ++c) {
        slices[c].resize(my_rows * static_cast<std::size_t>(columns[c].row_bytes()));
        if (columns[c].data)
            std::copy_n(columns[c].data, slices[c].size(), slices[c].data());
        else if (columns[c].make)
            columns[c].make(slices[c].data());
    }
    if (comm_.size() == 1) return slices;
    std::size_t width = 0;
    for (const Column& column : columns) width += static_cast<std::size_t>(column.row_bytes());
    std::vector<std::byte> mine(my_rows * width), packed(static_cast<std::size_t>(packed_rows_) * width);
    std::size_t before = 0;
    for (const Column& column : columns) {
        pack(column, before, width, mine.data());
        before += static_cast<std::size_t>(column.row_bytes());
    }
    const RowType row(static_cast<int>(width));
    MPI_Alltoallv(mine.data(), my_count_.data(), my_at_.data(), row.get(), packed.data(), all_count_.data(),
                  all_at_.data(), row.get(), comm_.handle());
    std::vector<std::byte>().swap(mine);
    before = 0;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto bytes = static_cast<std::size_t>(columns[c].row_bytes());
        slices[c].resize(static_cast<std::size_t>(slice_.count) * bytes);
        for (const Run& run : runs_) {
            const auto r = static_cast<std::size_t>(run.rank);
            const auto first = static_cast<std::size_t>(all_at_[r]), count = static_cast<std::size_t>(all_count_[r]);
            const std::byte* from = packed.data() + first * width + before * count;
            std::memcpy(slices[c].data() + static_cast<std::size_t>(run.at) * bytes,
                        from + (static_cast<std::size_t>(run.packed) - first) * bytes,
                        static_cast<std::size_t>(run.count) * bytes);
        }
        before += bytes;
    }
    return slices;
}

void RowOrder::from_file(const std::byte* slice, int row_bytes, std::byte* rows) const {
    const RowType row(row_bytes);
    const auto width = static_cast<std::size_t>(row_bytes);
    std::vector<std::byte> packed(static_cast<std::size_t>(packed_rows_) * width);
    for (const Run& run : runs_)
        std::memcpy(packed.data() + static_cast<std::size_t>(run.packed) * width,
                    slice + static_cast<std::size_t>(run.at) * width, static_cast<std::size_t>(run.count) * width);
    MPI_Alltoallv(packed.data(), all_count_.data(), all_at_.data(), row.get(), rows, my_count_.data(), my_at_.data(),
                  row.get(), comm_.handle());
}

}  // namespace moraine
