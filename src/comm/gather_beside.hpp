#pragma once
// Comm::all_gather() in parts, each of which is done when it is asked for a step later: nobody waits for anybody.

#include <exception>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

template <class T>
class GatherBeside {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    /// Rows of all ranks, rank by rank, and how many each has.
    struct Rows {
        std::vector<T> rows;
        std::vector<std::int64_t> counts;
    };

    explicit GatherBeside(const Comm& comm) : comm_(comm) {
        MPI_Type_contiguous(sizeof(T), MPI_BYTE, &row_);
        MPI_Type_commit(&row_);
    }
    GatherBeside(const GatherBeside&) = delete;
    GatherBeside& operator=(const GatherBeside&) = delete;
    ~GatherBeside() {
        if (std::uncaught_exceptions() == 0) finish();  // else others may never come
        MPI_Type_free(&row_);
    }

    /// At most 2^31 - 1 rows of all ranks. Nothing may be under way. Collective.
    void start(std::vector<T> mine) {
        mine_ = std::move(mine);
        count_ = static_cast<int>(mine_.size());
        counts_.resize(static_cast<std::size_t>(comm_.size()));
        part_ = Part::counts;
        MPI_Iallgather(&count_, 1, MPI_INT, counts_.data(), 1, MPI_INT, comm_.handle(), &request_);
    }
    bool under_way() const { return part_ != Part::none; }

    /// One part further; the rows, once they are there. Something must be under way. Collective.
    std::optional<Rows> advance() {
        MPI_Wait(&request_, MPI_STATUS_IGNORE);
        if (part_ == Part::counts) {
            places_.assign(counts_.size() + 1, 0);
            for (std::size_t r = 0; r < counts_.size(); ++r) places_[r + 1] = places_[r] + counts_[r];
            rows_.resize(static_cast<std::size_t>(places_.back()));
            part_ = Part::rows;
            MPI_Iallgatherv(mine_.data(), count_, row_, rows_.data(), counts_.data(), places_.data(), row_,
                            comm_.handle(), &request_);
            return {};
        }
        part_ = Part::none;
        return Rows{std::move(rows_), {counts_.begin(), counts_.end()}};
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
    std::vector<T> mine_, rows_;
    std::vector<int> counts_, places_;
    int count_ = 0;
};

}  // namespace moraine
