#include "gpu/transport/mpi_transport.hpp"

#if __has_include(<mpi-ext.h>)
#include <mpi-ext.h>
#endif

#include "gpu/memory/pinned_bytes.hpp"

namespace moraine::gpu {

namespace {

enum class MpiMemory { pinned, device };

class MpiTransport final : public Transport {
  public:
    MpiTransport(const Comm& comm, int tag, MpiMemory memory) : memory_(memory), messages_(comm, tag) {}

    const char* name() const override { return memory_ == MpiMemory::pinned ? "host" : "mpi"; }
    std::byte* const* outgoing() const override { return out_pointers_.out(); }
    const std::byte* const* incoming() const override { return in_pointers_.in(); }

    void open(const std::vector<TransportPeer>& peers) override {
        check(cudaDeviceSynchronize(), "Ending an epoch");
        const std::vector<std::size_t> out_at = capacity_starts(peers, &TransportPeer::capacity_out);
        const std::vector<std::size_t> in_at = capacity_starts(peers, &TransportPeer::capacity_in);
        here_.resize(in_at.back());
        if (memory_ == MpiMemory::pinned) {
            pinned_out_.resize(out_at.back());
            pinned_in_.resize(in_at.back());
        } else {
            device_out_.resize(out_at.back());
        }
        heads_.resize(peers.size() * sizeof(MessageHead));
        std::byte* const from = memory_ == MpiMemory::pinned ? pinned_out_.data() : device_out_.data();
        std::byte* const written = memory_ == MpiMemory::pinned ? pinned_out_.device() : device_out_.data();
        std::byte* const to = memory_ == MpiMemory::pinned ? pinned_in_.data() : here_.data();
        sends_.clear(), receives_.clear();
        std::vector<std::byte*> out_pointer, in_pointer;
        for (std::size_t k = 0; k < peers.size(); ++k) {
            sends_.push_back({peers[k].rank, from + out_at[k], 0,
                              static_cast<std::int64_t>(message_capacity(peers[k].capacity_out))});
            receives_.push_back(
                {peers[k].rank, to + in_at[k], 0, static_cast<std::int64_t>(message_capacity(peers[k].capacity_in))});
            out_pointer.push_back(written + out_at[k]);
            in_pointer.push_back(here_.data() + in_at[k]);
        }
        out_pointers_.assign(out_pointer);
        in_pointers_.assign(in_pointer);
    }

    void start(cudaStream_t stream) override {
        for (std::size_t k = 0; memory_ == MpiMemory::device && k < sends_.size(); ++k)
            check(cudaMemcpyAsync(heads_.data() + k * sizeof(MessageHead), sends_[k].data, sizeof(MessageHead),
                                  cudaMemcpyDeviceToHost, stream),
                  "Reading the length of a message");
        written_.record(stream);
    }

    void post() override {
        written_.wait();
        for (std::size_t k = 0; k < sends_.size(); ++k) {
            const std::byte* head =
                memory_ == MpiMemory::pinned ? sends_[k].data : heads_.data() + k * sizeof(MessageHead);
            sends_[k].bytes = static_cast<std::int64_t>(reinterpret_cast<const MessageHead*>(head)->bytes);
        }
        messages_.start(sends_, receives_);
    }

    void finish(cudaStream_t stream) override {
        messages_.finish();
        for (const Parcel& parcel : receives_) {
            if (memory_ == MpiMemory::device) break;
            check(cudaMemcpyAsync(here_.data() + (parcel.data - pinned_in_.data()), parcel.data,
                                  static_cast<std::size_t>(parcel.bytes), cudaMemcpyHostToDevice, stream),
                  "Taking a message in");
        }
    }

  private:
    MpiMemory memory_;
    PointToPoint messages_;
    PinnedBytes pinned_out_, pinned_in_, heads_;
    Array<std::byte> device_out_, here_;
    std::vector<Parcel> sends_, receives_;
    PointerArray out_pointers_, in_pointers_;
    Event written_;
};

class MpiTransports final : public TransportFactory {
  public:
    MpiTransports(const Comm& comm, MpiMemory memory) : comm_(comm), memory_(memory) {}
    const char* name() const override { return memory_ == MpiMemory::pinned ? "host" : "mpi"; }
    std::unique_ptr<Transport> make(int tag) const override {
        return std::make_unique<MpiTransport>(comm_, tag, memory_);
    }

  private:
    const Comm& comm_;
    MpiMemory memory_;
};

}  // namespace

std::string mpi_obstacle(const Comm&) {
#if defined(MPIX_CUDA_AWARE_SUPPORT)
    if (MPIX_Query_cuda_support() == 1) return {};
#endif
    return "this MPI does not take device memory";
}

std::unique_ptr<TransportFactory> mpi_transports(const Comm& comm) {
    return std::make_unique<MpiTransports>(comm, MpiMemory::device);
}

std::string host_obstacle(const Comm&) {
    return {};
}

std::unique_ptr<TransportFactory> host_transports(const Comm& comm) {
    return std::make_unique<MpiTransports>(comm, MpiMemory::pinned);
}

}  // namespace moraine::gpu
