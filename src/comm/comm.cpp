#include "comm/comm.hpp"

#include <algorithm>
#include <climits>

namespace moraine {

namespace {
constexpr std::int64_t chunk = std::int64_t(1) << 30;  // MPI counts are int

template <class T>
T reduced(const Comm& comm, T value, MPI_Datatype type, MPI_Op op) {
    T result{};
    MPI_Allreduce(&value, &result, 1, type, op, comm.handle());
    return result;
}
}  // namespace

Comm::Comm(MPI_Comm parent) {
    MPI_Comm_dup(parent, &comm_);
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &size_);
}

Comm::~Comm() {
    MPI_Comm_free(&comm_);
}

Comm::Neighbours Comm::on_this_machine() const {
    MPI_Comm here = MPI_COMM_NULL;
    Neighbours n{0, 1};
    MPI_Comm_split_type(comm_, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
    MPI_Comm_rank(here, &n.rank);
    MPI_Comm_size(here, &n.size);
    MPI_Comm_free(&here);
    return n;
}

void Comm::barrier() const {
    MPI_Barrier(comm_);
}
double Comm::min(double value) const {
    return reduced(*this, value, MPI_DOUBLE, MPI_MIN);
}
double Comm::max(double value) const {
    return reduced(*this, value, MPI_DOUBLE, MPI_MAX);
}
double Comm::sum(double value) const {
    return reduced(*this, value, MPI_DOUBLE, MPI_SUM);
}
std::int64_t Comm::max(std::int64_t value) const {
    return reduced(*this, value, MPI_INT64_T, MPI_MAX);
}
std::int64_t Comm::sum(std::int64_t value) const {
    return reduced(*this, value, MPI_INT64_T, MPI_SUM);
}

std::uint64_t Comm::sum(std::uint64_t value) const {
    return reduced(*this, value, MPI_UINT64_T, MPI_SUM);
}

void Comm::sum(std::span<std::int64_t> values) const {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT64_T, MPI_SUM, comm_);
}

void Comm::unite(std::span<std::uint64_t> bits) const {
    MPI_Allreduce(MPI_IN_PLACE, bits.data(), static_cast<int>(bits.size()), MPI_UINT64_T, MPI_BOR, comm_);
}

std::string Comm::broadcast(const std::string& text, int root) const {
    std::int64_t length = static_cast<std::int64_t>(text.size());
    MPI_Bcast(&length, 1, MPI_INT64_T, root, comm_);
    std::string result = rank_ == root ? text : std::string(static_cast<std::size_t>(length), ' ');
    for (std::int64_t at = 0; at < length; at += chunk)
        MPI_Bcast(result.data() + at, static_cast<int>(std::min(chunk, length - at)), MPI_CHAR, root, comm_);
    return result;
}

/// Each of `rows` becomes the sum of all ranks' by `add`, which does not mind the order.
void Comm::reduce(void* rows, std::size_t count, std::size_t bytes, MPI_User_function* add) const {
    MPI_Datatype row = MPI_DATATYPE_NULL;
    MPI_Op op = MPI_OP_NULL;
    MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &row);
    MPI_Type_commit(&row);
    MPI_Op_create(add, 1, &op);
    MPI_Allreduce(MPI_IN_PLACE, rows, static_cast<int>(count), row, op, comm_);
    MPI_Op_free(&op);
    MPI_Type_free(&row);
}

std::vector<std::int64_t> Comm::gather_counts(std::int64_t mine) const {
    std::vector<std::int64_t> counts(static_cast<std::size_t>(size_));
    MPI_Allgather(&mine, 1, MPI_INT64_T, counts.data(), 1, MPI_INT64_T, comm_);
    return counts;
}

void Comm::gather_bytes(const void* mine, const std::vector<std::int64_t>& bytes, void* all) const {
    std::int64_t total = 0;
    for (auto b : bytes) total += b;
    if (total <= INT_MAX) {
        std::vector<int> counts, offsets;
        int at = 0;
        for (auto b : bytes) {
            counts.push_back(static_cast<int>(b));
            offsets.push_back(at);
            at += static_cast<int>(b);
        }
        MPI_Allgatherv(mine, counts[static_cast<std::size_t>(rank_)], MPI_BYTE, all, counts.data(), offsets.data(),
                       MPI_BYTE, comm_);
        return;
    }
    auto* to = static_cast<char*>(all);
    for (int r = 0; r < size_; ++r) {
        const std::int64_t length = bytes[static_cast<std::size_t>(r)];
        if (r == rank_) std::copy_n(static_cast<const char*>(mine), length, to);
        for (std::int64_t at = 0; at < length; at += chunk)
            MPI_Bcast(to + at, static_cast<int>(std::min(chunk, length - at)), MPI_BYTE, r, comm_);
        to += length;
    }
}

std::vector<std::int64_t> Comm::swap_counts(const std::vector<std::int64_t>& mine) const {
    std::vector<std::int64_t> theirs(mine.size());
    MPI_Alltoall(mine.data(), 1, MPI_INT64_T, theirs.data(), 1, MPI_INT64_T, comm_);
    return theirs;
}

void Comm::exchange_rows(const void* rows, const std::vector<std::int64_t>& sent, void* into,
                         const std::vector<std::int64_t>& received, std::size_t bytes) const {
    const auto places = [](const std::vector<std::int64_t>& counts, std::vector<int>& n) {
        std::vector<int> at;
        int sum = 0;
        for (std::int64_t count : counts) {
            n.push_back(static_cast<int>(count));
            at.push_back(sum);
            sum += static_cast<int>(count);
        }
        return at;
    };
    std::vector<int> to, from;
    const std::vector<int> to_at = places(sent, to), from_at = places(received, from);
    MPI_Datatype row = MPI_DATATYPE_NULL;
    MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &row);
    MPI_Type_commit(&row);
    MPI_Alltoallv(rows, to.data(), to_at.data(), row, into, from.data(), from_at.data(), row, comm_);
    MPI_Type_free(&row);
}

std::string Comm::first_words(const std::string& mine) const {
    const std::int64_t speaks = mine.empty() ? size_ : rank_;
    std::int64_t first = size_;
    MPI_Allreduce(&speaks, &first, 1, MPI_INT64_T, MPI_MIN, comm_);
    return first == size_ ? std::string() : broadcast(mine, static_cast<int>(first));
}

}  // namespace moraine
