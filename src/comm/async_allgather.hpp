#pragma once
// Comm::all_gather() in parts, each of which is done when it is asked for a step later: nobody waits for anybody.

#include <exception>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

template <class T>
class AsyncAllgather {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    /// Rows of all ranks, rank by rank, and how many each has.
    struct Rows {
        std::vector<T> rows;
        std::vector<std::int64_t> counts;
    };

    explicit AsyncAllgather(const Comm& comm) : comm_(comm) {
        MPI_Type_contiguous(sizeof(T), MPI_BYTE, &row_);
        MPI_Type_commit(&row_);
    }
    AsyncAllgather(const AsyncAllgather&) = delete;
    AsyncAllgather& operator=(const AsyncAllgather&) = delete;
    ~AsyncAllgather() {
        if (under_way() && std::uncaught_exceptions() == 0) finish();
        if (under_way()) (void)buffers_.release();  // others may never come, and MPI may still write
        MPI_Type_free(&row_);
    }

    /// At most 2^31 - 1 rows of all ranks. Nothing may be under way. Collective.
    void start(std::vector<T> mine) {
        Buffers& b = *buffers_;
        b.mine = std::move(mine);
        b.count = static_cast<int>(b.mine.size());
        b.counts.resize(static_cast<std::size_t>(comm_.size()));
        part_ = Part::counts;
        MPI_Iallgather(&b.count, 1, MPI_INT, b.counts.data(), 1, MPI_INT, comm_.handle(), &request_);
    }
    bool under_way() const { return part_ != Part::none; }

    /// One part further; the rows, once they are there. Something must be under way. Collective.
    std::optional<Rows> advance() {
        MPI_Wait(&request_, MPI_STATUS_IGNORE);
        Buffers& b = *buffers_;
        if (part_ == Part::rows) {
            part_ = Part::none;
            return Rows{std::move(b.rows), {b.counts.begin(), b.counts.end()}};
        }
        b.places.assign(b.counts.size() + 1, 0);
        for (std::size_t r = 0; r < b.counts.size(); ++r) b.places[r + 1] = b.places[r] + b.counts[r];
        b.rows.resize(static_cast<std::size_t>(b.places.back()));
        part_ = Part::rows;
        MPI_Iallgatherv(b.mine.data(), b.count, row_, b.rows.data(), b.counts.data(), b.places.data(), row_,
                        comm_.handle(), &request_);
        return {};
    }

    /// All that is left of it, if it is under way. Collective.
    std::optional<Rows> finish() {
        std::optional<Rows> all;
        while (under_way()) all = advance();
        return all;
    }

  private:
    enum class Part { none, counts, rows };

    const Comm& comm_;
    MPI_Datatype row_ = MPI_DATATYPE_NULL;
    MPI_Request request_ = MPI_REQUEST_NULL;
    Part part_ = Part::none;
    struct Buffers {
        std::vector<T> mine, rows;
        std::vector<int> counts, places;
        int count = 0;
    };
    std::unique_ptr<Buffers> buffers_ = std::make_unique<Buffers>();
};

}  // namespace moraine
