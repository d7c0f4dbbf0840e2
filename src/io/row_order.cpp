#include "io/row_order.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace moraine {

namespace {

RowRange slice_of(std::int64_t rows, int rank, int ranks) {
    const std::int64_t begin = rows / ranks * rank + std::min<std::int64_t>(rank, rows % ranks);
    const std::int64_t end = rows / ranks * (rank + 1) + std::min<std::int64_t>(rank + 1, rows % ranks);
    return {begin, end - begin};
}

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

FileOrder file_order(const Comm& comm, std::span<const BlockRow> my_blocks) {
    FileOrder order;
    order.blocks = comm.all_gather(std::vector<BlockRow>(my_blocks.begin(), my_blocks.end()));
    std::sort(order.blocks.begin(), order.blocks.end(),
              [](const BlockRow& a, const BlockRow& b) { return a.key < b.key; });
    std::size_t next = 0;
    for (const BlockRow& block : order.blocks) {
        if (next < my_blocks.size() && my_blocks[next].key == block.key) {
            order.mine.push_back({order.rows, block.count});
            ++next;
        }
        order.rows += block.count;
    }
    if (next != my_blocks.size()) throw std::logic_error("a rank's blocks do not ascend by key");
    return order;
}

RowOrder::RowOrder(const Comm& comm, std::span<const RowRange> mine, std::int64_t file_rows)
    : comm_(comm), slice_(slice_of(file_rows, comm.rank(), comm.size())) {
    const auto ranks = static_cast<std::size_t>(comm.size());
    my_count_.assign(ranks, 0);
    all_count_.assign(ranks, 0);
    int holder = 0;
    for (const RowRange& range : mine)
        for (std::int64_t left = range.count; left > 0;) {
            const std::int64_t at = range.start + range.count - left;
            RowRange slice = slice_of(file_rows, holder, comm.size());
            while (holder + 1 < comm.size() && at >= slice.start + slice.count)
                slice = slice_of(file_rows, ++holder, comm.size());
            const std::int64_t here = common({at, left}, slice).count;
            if (here == 0) throw std::logic_error("ranges of rows descend or leave the file");
            int& count = my_count_[static_cast<std::size_t>(holder)];
            count = checked(count + here);
            left -= here;
        }
    std::vector<std::int64_t> ranges_of;
    const auto all = comm.all_gather(std::vector<RowRange>(mine.begin(), mine.end()), &ranges_of);
    auto range = all.begin();
    for (std::size_t r = 0; r < ranks; ++r)
        for (std::int64_t k = 0; k < ranges_of[r]; ++k, ++range) {
            const RowRange here = common(*range, slice_);
            if (here.count == 0) continue;
            runs_.push_back({here.start - slice_.start, packed_rows_, here.count});
            all_count_[r] = checked(all_count_[r] + here.count);
            packed_rows_ += here.count;
        }
    my_at_ = starts_of(my_count_);
    all_at_ = starts_of(all_count_);
}

std::vector<std::byte> RowOrder::to_file(const Column& column) const {
    const RowType row(column.row_bytes());
    const auto width = static_cast<std::size_t>(column.row_bytes());
    const auto my_rows = static_cast<std::size_t>(my_at_.back() + my_count_.back());
    std::vector<std::byte> made;
    if (!column.data && column.make) {
        made.resize(my_rows * width);
        column.make(made.data());
        if (comm_.size() == 1) return made;
    }
    const std::byte* rows = column.data ? column.data : made.data();
    std::vector<std::byte> packed(static_cast<std::size_t>(packed_rows_) * width);
    MPI_Alltoallv(rows, my_count_.data(), my_at_.data(), row.get(), packed.data(), all_count_.data(), all_at_.data(),
                  row.get(), comm_.handle());
    std::vector<std::byte> slice(static_cast<std::size_t>(slice_.count) * width);
    for (const Run& run : runs_)
        std::memcpy(slice.data() + static_cast<std::size_t>(run.at) * width,
                    packed.data() + static_cast<std::size_t>(run.packed) * width,
                    static_cast<std::size_t>(run.count) * width);
    return slice;
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
