#include "engine/agreement.hpp"

namespace moraine {

namespace {
constexpr int most_direct = 16;  // ranks that tell each other: above, a tree has fewer messages
constexpr int tag = 4;           // beside those of host/host_engine.hpp

void combine(const Agreement& a, Agreement& b) {
    b.signal = std::max(a.signal, b.signal);
    b.square_speed = std::max(a.square_speed, b.square_speed);
    b.moved = std::max(a.moved, b.moved);
    b.seconds = std::max(a.seconds, b.seconds);
    b.seconds_sum += a.seconds_sum;
    b.count = std::max(a.count, b.count);
    b.count_sum += a.count_sum;
    b.asleep_sum += a.asleep_sum;
    b.load = std::max(a.load, b.load);
    b.load_sum += a.load_sum;
    b.blocks += a.blocks;
    b.migration_bound.take_most(a.migration_bound);
    b.faults |= a.faults;
    b.in_guard_layer |= a.in_guard_layer;
    b.making |= a.making;
    b.writing |= a.writing;
    b.stop |= a.stop;
}

void combine_rows(void* in, void* in_out, int* n, MPI_Datatype*) {
    for (int k = 0; k < *n; ++k) combine(static_cast<const Agreement*>(in)[k], static_cast<Agreement*>(in_out)[k]);
}
}  // namespace

AgreementReduction::AgreementReduction(const Comm& comm)
    : comm_(comm), of_ranks_(static_cast<std::size_t>(comm.size())) {
    MPI_Type_contiguous(sizeof(Agreement), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
    MPI_Op_create(combine_rows, 1, &op_);
}

AgreementReduction::~AgreementReduction() {
    MPI_Op_free(&op_);
    MPI_Type_free(&type_);
}

void AgreementReduction::start(const Agreement& mine) {
    mine_ = mine;
    mine_.seconds_sum = mine.seconds;
    mine_.count_sum = mine.count;
    mine_.load_sum = mine.load;
    requests_.clear();
    if (comm_.size() > most_direct) {
        requests_.emplace_back();
        MPI_Iallreduce(&mine_, &of_ranks_[0], 1, type_, op_, comm_.handle(), &requests_[0]);
        return;
    }
    const auto begin = [&](int r, auto call, Agreement* data) {
        if (r == comm_.rank()) return;
        requests_.emplace_back();
        call(data, 1, type_, r, tag, comm_.handle(), &requests_.back());
    };
    for (int r = 0; r < comm_.size(); ++r) begin(r, MPI_Irecv, &of_ranks_[static_cast<std::size_t>(r)]);
    for (int r = 0; r < comm_.size(); ++r) begin(r, MPI_Isend, &mine_);
}

Agreement AgreementReduction::finish() {
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    if (comm_.size() > most_direct) return of_ranks_[0];
    of_ranks_[static_cast<std::size_t>(comm_.rank())] = mine_;
    Agreement all = of_ranks_[0];
    for (std::size_t r = 1; r < of_ranks_.size(); ++r) combine(of_ranks_[r], all);
    return all;
}

}  // namespace moraine
