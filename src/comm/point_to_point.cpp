#include "comm/point_to_point.hpp"

#include <algorithm>

namespace moraine {

namespace {
constexpr std::int64_t piece = std::int64_t(1) << 30;

std::int64_t pieces(std::int64_t capacity) {
    return std::max<std::int64_t>(1, (capacity + piece - 1) / piece);
}
}  // namespace

void PointToPoint::start(std::span<Parcel> sends, std::span<Parcel> receives) {
    receives_ = receives;
    requests_.clear();
    owner_.clear();
    for (std::size_t r = 0; r < receives.size(); ++r) {
        receives[r].bytes = 0;
        for (std::int64_t k = 0; k < pieces(receives[r].capacity); ++k) {
            const std::int64_t capacity = std::min(piece, receives[r].capacity - k * piece);
            requests_.emplace_back();
            owner_.push_back(static_cast<int>(r));
            MPI_Irecv(receives[r].data + k * piece, static_cast<int>(capacity), MPI_BYTE, receives[r].peer, tag_,
                      comm_.handle(), &requests_.back());
        }
    }
    for (const Parcel& send : sends)
        for (std::int64_t k = 0; k < pieces(send.capacity); ++k) {
            const std::int64_t length = std::clamp<std::int64_t>(send.bytes - k * piece, 0, piece);
            requests_.emplace_back();
            owner_.push_back(-1);
            MPI_Isend(send.data + k * piece, static_cast<int>(length), MPI_BYTE, send.peer, tag_, comm_.handle(),
                      &requests_.back());
        }
}

void PointToPoint::finish() {
    std::vector<MPI_Status> statuses(requests_.size());
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), statuses.data());
    for (std::size_t k = 0; k < requests_.size(); ++k) {
        if (owner_[k] < 0) continue;
        int count = 0;
        MPI_Get_count(&statuses[k], MPI_BYTE, &count);
        receives_[static_cast<std::size_t>(owner_[k])].bytes += count;
    }
    requests_.clear();
    owner_.clear();
}

std::vector<std::vector<std::byte>> exchange_all(const Comm& comm, const std::vector<std::vector<std::byte>>& to) {
    const auto ranks = static_cast<std::size_t>(comm.size());
    std::vector<std::int64_t> sent(ranks), come(ranks);
    for (std::size_t r = 0; r < ranks; ++r) sent[r] = static_cast<std::int64_t>(to[r].size());
    MPI_Alltoall(sent.data(), 1, MPI_INT64_T, come.data(), 1, MPI_INT64_T, comm.handle());
    std::vector<std::vector<std::byte>> from(ranks);
    std::vector<Parcel> sends, receives;
    for (std::size_t r = 0; r < ranks; ++r) {
        from[r].resize(static_cast<std::size_t>(come[r]));
        const int peer = static_cast<int>(r);
        if (peer == comm.rank()) {
            from[r] = to[r];
            continue;
        }
        if (sent[r] > 0) sends.push_back({peer, const_cast<std::byte*>(to[r].data()), sent[r], sent[r]});
        if (come[r] > 0) receives.push_back({peer, from[r].data(), 0, come[r]});
    }
    PointToPoint messages(comm, 3);
    messages.start(sends, receives);
    messages.finish();
    return from;
}

}  // namespace moraine
