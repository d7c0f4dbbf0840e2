#include "gpu/transport/peer_transport.hpp"

#include <algorithm>

#include "comm/host_groups.hpp"
#include "gpu/transport/mailboxes.hpp"
#include "gpu/transport/stream_flags.hpp"

namespace moraine::gpu {

namespace {

/// Device memory of each rank that the others can write, mapped into this process.
class SharedInboxes {
  public:
    explicit SharedInboxes(const Comm& comm) : comm_(comm) {}
    SharedInboxes(const SharedInboxes&) = delete;
    SharedInboxes& operator=(const SharedInboxes&) = delete;
    ~SharedInboxes() {
        unmap();
        cudaFree(mine_);
    }

    std::byte* mine() const { return mine_; }
    /// Inbox of another rank.
    std::byte* of(int rank) const { return mapped_[static_cast<std::size_t>(rank)]; }

    /// Capacity for `bytes` here; where any rank needs more than it has, all exchange theirs anew. Collective.
    void reserve(std::size_t bytes) {
        bytes = std::max<std::size_t>(bytes, 1);  // even an inbox of nothing has an address
        if (comm_.max(static_cast<double>(bytes > size_)) == 0) return;
        unmap();
        comm_.barrier();  // nobody maps what is given back
        std::string wrong;
        cudaIpcMemHandle_t handle{};
        try {
            if (bytes > size_) allocate(bytes);
            check(cudaIpcGetMemHandle(&handle, mine_), "Sharing device memory");
        } catch (const MachineError& e) {
            wrong = e.what();
        }
        const std::vector<cudaIpcMemHandle_t> handles = comm_.all_gather(std::vector<cudaIpcMemHandle_t>{handle});
        comm_.agree_no_error<MachineError>(wrong);
        try {
            map(handles);
        } catch (const MachineError& e) {
            wrong = e.what();
        }
        comm_.agree_no_error<MachineError>(wrong);
    }

  private:
    /// Whole pages of the driver: a small piece could share one with memory of others.
    void allocate(std::size_t bytes) {
        constexpr std::size_t page = std::size_t(2) << 20, slack = 32 * page;  // to map memory anew takes long
        cudaFree(mine_);
        mine_ = nullptr;
        size_ = (bytes + std::max(bytes / 8, std::min(bytes, slack)) + page - 1) / page * page;
        check(cudaMalloc(reinterpret_cast<void**>(&mine_), size_), "Allocating device memory");
    }

    void map(const std::vector<cudaIpcMemHandle_t>& handles) {
        mapped_.assign(handles.size(), nullptr);
        for (std::size_t r = 0; r < handles.size(); ++r)
            if (static_cast<int>(r) != comm_.rank())
                check(cudaIpcOpenMemHandle(reinterpret_cast<void**>(&mapped_[r]), handles[r],
                                           cudaIpcMemLazyEnablePeerAccess),
                      "Opening a peer's device memory");
    }

    void unmap() {
        cudaDeviceSynchronize();
        for (std::byte* other : mapped_)
            if (other) cudaIpcCloseMemHandle(other);
        mapped_.clear();
    }

    const Comm& comm_;
    std::byte* mine_ = nullptr;
    std::size_t size_ = 0;
    std::vector<std::byte*> mapped_;
};

/// Where rank `to` puts what comes from rank `from`.
struct Place {
    int from, to;
    std::uint64_t box[2];
    std::uint64_t flag;
};

class PeerTransport final : public TwoSetTransport {
  public:
    explicit PeerTransport(const Comm& comm) : comm_(comm), inboxes_(comm) {}

    const char* name() const override { return "peer"; }
    std::byte* const* outgoing() const override { return pointers_.out() + outgoing_set() * my_flags_.size(); }
    const std::byte* const* incoming() const override {
        return pointers_.in() + (2 + incoming_set()) * my_flags_.size();
    }
    std::size_t outgoing_set() const override { return (round_ + 1) & 1; }
    std::size_t incoming_set() const override { return round_ & 1; }
    std::vector<std::byte*> outgoing_pointers(int set) const override { return out_[set]; }
    std::vector<std::byte*> incoming_pointers(int set) const override { return in_[set]; }

    /// Where all boxes are large enough they stay, and what is under way goes on.
    void open(const std::vector<TransportPeer>& asked) override {
        if (comm_.max(static_cast<std::int64_t>(!fits(asked))) == 0) return;
        check(cudaDeviceSynchronize(), "Ending an epoch");
        std::vector<TransportPeer>& peers = peers_ = asked;
        for (TransportPeer& peer : peers) peer.capacity_in += peer.capacity_in / 8;
        const std::vector<std::size_t> start = capacity_starts(peers, &TransportPeer::capacity_in);
        const std::size_t flags = peers.size() * message_align;
        inboxes_.reserve(flags + 2 * start.back());
        if (flags > 0) check(cudaMemset(inboxes_.mine(), 0, flags), "Clearing flags");
        check(cudaDeviceSynchronize(), "Clearing flags");

        std::vector<Place> mine;
        for (std::size_t k = 0; k < peers.size(); ++k)
            mine.push_back(
                {peers[k].rank, comm_.rank(), {flags + start[k], flags + start.back() + start[k]}, k * message_align});
        address(peers, comm_.all_gather(mine), mine);  // the gather: all flags are down before one is raised
        round_ = 0;
    }

    void start(cudaStream_t stream) override {
        raise_flags(reinterpret_cast<std::uint32_t* const*>(pointers_.out() + 4 * my_flags_.size()),
                    static_cast<int>(my_flags_.size()), ++round_, stream);
    }
    void post() override {}
    void finish(cudaStream_t stream) override {
        for (const std::uint32_t* flag : my_flags_) wait_for_flag(flag, round_, stream);
    }

  private:
    bool fits(const std::vector<TransportPeer>& asked) const {
        return std::equal(asked.begin(), asked.end(), peers_.begin(), peers_.end(),
                          [](const TransportPeer& a, const TransportPeer& b) {
                              return a.rank == b.rank && a.capacity_in <= b.capacity_in;
                          });
    }

    void address(const std::vector<TransportPeer>& peers, const std::vector<Place>& all,
                 const std::vector<Place>& mine) {
        std::vector<std::byte*> flags;
        for (int set = 0; set < 2; ++set) out_[set].clear(), in_[set].clear();
        my_flags_.clear();
        for (const Place& p : mine) {
            for (int parity = 0; parity < 2; ++parity) in_[parity].push_back(inboxes_.mine() + p.box[parity]);
            my_flags_.push_back(reinterpret_cast<const std::uint32_t*>(inboxes_.mine() + p.flag));
        }
        for (const TransportPeer& peer : peers) {
            const auto place = std::find_if(
                all.begin(), all.end(), [&](const Place& p) { return p.from == comm_.rank() && p.to == peer.rank; });
            if (place == all.end()) throw std::logic_error("a peer does not know its peer");
            std::byte* const box = inboxes_.of(peer.rank);
            for (int parity = 0; parity < 2; ++parity) out_[parity].push_back(box + place->box[parity]);
            flags.push_back(box + place->flag);
        }
        std::vector<std::byte*> all_pointers;
        for (const std::vector<std::byte*>& some : {out_[0], out_[1], in_[0], in_[1], flags})
            all_pointers.insert(all_pointers.end(), some.begin(), some.end());
        pointers_.assign(all_pointers);
    }

    const Comm& comm_;
    SharedInboxes inboxes_;
    std::vector<TransportPeer> peers_;        ///< whose boxes there are, and how large they are
    std::vector<std::byte*> out_[2], in_[2];  ///< boxes of both parities, by peer
    PointerArray pointers_;  ///< outgoing boxes of both parities, incoming ones of both, peers' flags: by peer
    std::vector<const std::uint32_t*> my_flags_;
    std::uint32_t round_ = 0;
};

class PeerTransports final : public TransportFactory {
  public:
    explicit PeerTransports(const Comm& comm) : comm_(comm) {}
    const char* name() const override { return "peer"; }
    std::unique_ptr<Transport> make(int) const override { return std::make_unique<PeerTransport>(comm_); }

  private:
    const Comm& comm_;
};

}  // namespace

std::string peer_obstacle(const Comm& comm) {
    return host_count(find_hosts(comm)) == 1 ? "" : "the ranks are on several hosts";
}

std::unique_ptr<TwoSetTransport> peer_transport(const Comm& comm) {
    return std::make_unique<PeerTransport>(comm);
}

std::unique_ptr<TransportFactory> peer_transports(const Comm& comm) {
    return std::make_unique<PeerTransports>(comm);
}

}  // namespace moraine::gpu
