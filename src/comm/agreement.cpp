#include "comm/agreement.hpp"

namespace moraine {

namespace {
void combine(void* in, void* in_out, int* n, MPI_Datatype*) {
    const auto* a = static_cast<const Agreement*>(in);
    auto* b = static_cast<Agreement*>(in_out);
    for (int k = 0; k < *n; ++k) {
        b[k].signal = std::max(a[k].signal, b[k].signal);
        b[k].moved = std::max(a[k].moved, b[k].moved);
        b[k].seconds = std::max(a[k].seconds, b[k].seconds);
        b[k].seconds_sum += a[k].seconds_sum;
        b[k].count = std::max(a[k].count, b[k].count);
        b[k].count_sum += a[k].count_sum;
        b[k].blocks += a[k].blocks;
        b[k].migration_bound.take_most(a[k].migration_bound);
        b[k].faults |= a[k].faults;
        b[k].in_guard_layer |= a[k].in_guard_layer;
        b[k].making |= a[k].making;
        b[k].stop |= a[k].stop;
    }
}
}  // namespace

AgreementReduction::AgreementReduction(const Comm& comm) : comm_(comm) {
    MPI_Type_contiguous(sizeof(Agreement), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
    MPI_Op_create(combine, 1, &op_);
}

AgreementReduction::~AgreementReduction() {
    MPI_Op_free(&op_);
    MPI_Type_free(&type_);
}

void AgreementReduction::start(const Agreement& mine) {
    mine_ = mine;
    mine_.seconds_sum = mine.seconds;
    mine_.count_sum = mine.count;
    MPI_Iallreduce(&mine_, &all_, 1, type_, op_, comm_.handle(), &request_);
}

Agreement AgreementReduction::finish() {
    MPI_Wait(&request_, MPI_STATUS_IGNORE);
    return all_;
}

}  // namespace moraine
