#include "gpu/transport/nccl_transport.hpp"

#include <nccl.h>

#include <cstring>

#include "core/data/rank_failure.hpp"
#include "gpu/memory/pinned_bytes.hpp"
#include "gpu/memory/stream.hpp"
#include "gpu/transport/mailboxes.hpp"

namespace moraine::gpu {

namespace {

void check(ncclResult_t e, const char* what) {
    if (e != ncclSuccess)
        throw RankFailure(std::string(what) + " failed (NCCL: " + ncclGetErrorString(e) + "). Use --transport host?");
}
using gpu::check;

/// Whether two ranks compute on one device. Collective.
bool devices_are_shared(const Comm& comm) {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "Asking for the device");
    check(cudaGetDeviceProperties(&properties, device), "Asking the device");
    const std::vector<cudaUUID_t> all = comm.all_gather(std::vector<cudaUUID_t>{properties.uuid});
    int same = 0;
    for (const cudaUUID_t& other : all) same += std::memcmp(&other, &properties.uuid, sizeof(other)) == 0;
    return comm.max(static_cast<double>(same)) > 1;
}

/// All transports of a run are one communicator's: to join one takes a second.
class Nccl {
  public:
    /// Collective.
    explicit Nccl(const Comm& comm) {
        ncclUniqueId id{};
        if (comm.is_root()) check(ncclGetUniqueId(&id), "Starting NCCL");
        const std::string word = comm.broadcast(std::string(id.internal, sizeof(id.internal)));
        std::copy(word.begin(), word.end(), id.internal);
        check(ncclCommInitRank(&comm_, comm.size(), id, comm.rank()), "Joining NCCL");
    }
    Nccl(const Nccl&) = delete;
    Nccl& operator=(const Nccl&) = delete;
    ~Nccl() { ncclCommDestroy(comm_); }
    operator ncclComm_t() const { return comm_; }

  private:
    ncclComm_t comm_ = nullptr;
};

class NcclTransport final : public Transport {
  public:
    NcclTransport(const Comm& comm, std::shared_ptr<const Nccl> nccl, int tag)
        : mpi_(comm), tag_(tag), nccl_(std::move(nccl)) {}

    const char* name() const override { return "nccl"; }
    std::byte* const* outgoing() const override { return out_pointers_.out(); }
    const std::byte* const* incoming() const override { return in_pointers_.in(); }

    void open(const std::vector<TransportPeer>& peers) override {
        check(cudaDeviceSynchronize(), "Ending an epoch");
        const std::vector<std::size_t> out_at = capacity_starts(peers, &TransportPeer::capacity_out);
        const std::vector<std::size_t> in_at = capacity_starts(peers, &TransportPeer::capacity_in);
        out_.resize(out_at.back());
        in_.resize(in_at.back());
        heads_.resize(peers.size() * sizeof(MessageHead));
        peers_.clear(), sends_.clear(), receives_.clear();
        for (std::size_t k = 0; k < peers.size(); ++k) {
            peers_.push_back(peers[k].rank);
            sends_.push_back(out_.data() + out_at[k]);
            receives_.push_back(in_.data() + in_at[k]);
        }
        out_pointers_.assign(sends_);
        in_pointers_.assign(receives_);
    }

    void start(cudaStream_t stream) override {
        stream_ = stream;
        for (std::size_t k = 0; k < peers_.size(); ++k)
            check(cudaMemcpyAsync(heads_.data() + k * sizeof(MessageHead), sends_[k], sizeof(MessageHead),
                                  cudaMemcpyDeviceToHost, stream),
                  "Reading the length of a message");
        written_.record(stream);
    }

    void post() override {
        written_.wait();
        const std::size_t n = peers_.size();
        std::vector<std::uint64_t> leaving(n), coming(n);
        std::vector<MPI_Request> requests(2 * n);
        for (std::size_t k = 0; k < n; ++k) {
            leaving[k] = reinterpret_cast<const MessageHead*>(heads_.data())[k].bytes;
            MPI_Irecv(&coming[k], 8, MPI_BYTE, peers_[k], tag_, mpi_.handle(), &requests[k]);
            MPI_Isend(&leaving[k], 8, MPI_BYTE, peers_[k], tag_, mpi_.handle(), &requests[n + k]);
        }
        MPI_Waitall(static_cast<int>(2 * n), requests.data(), MPI_STATUSES_IGNORE);
        check(ncclGroupStart(), "Sending");
        for (std::size_t k = 0; k < n; ++k) {
            check(ncclSend(sends_[k], leaving[k], ncclUint8, peers_[k], *nccl_, stream_), "Sending");
            check(ncclRecv(receives_[k], coming[k], ncclUint8, peers_[k], *nccl_, stream_), "Receiving");
        }
        check(ncclGroupEnd(), "Sending");
    }

    void finish(cudaStream_t) override {}  // the stream that the messages are queued on

  private:
    const Comm& mpi_;
    int tag_;
    std::shared_ptr<const Nccl> nccl_;
    cudaStream_t stream_ = nullptr;
    Array<std::byte> out_, in_;
    PinnedBytes heads_;
    std::vector<int> peers_;
    std::vector<std::byte*> sends_, receives_;
    PointerArray out_pointers_, in_pointers_;
    Event written_;
};

class NcclTransports final : public TransportFactory {
  public:
    explicit NcclTransports(const Comm& comm) : comm_(comm), nccl_(std::make_shared<const Nccl>(comm)) {}
    const char* name() const override { return "nccl"; }
    std::unique_ptr<Transport> make(int tag) const override {
        return std::make_unique<NcclTransport>(comm_, nccl_, tag);
    }

  private:
    const Comm& comm_;
    std::shared_ptr<const Nccl> nccl_;
};

}  // namespace

std::string nccl_obstacle(const Comm& comm) {
    return devices_are_shared(comm) ? "ranks share a device, which NCCL does not allow" : "";
}

std::unique_ptr<TransportFactory> nccl_transports(const Comm& comm) {
    return std::make_unique<NcclTransports>(comm);
}

}  // namespace moraine::gpu
