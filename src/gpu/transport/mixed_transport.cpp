#include "gpu/transport/mixed_transport.hpp"

#include "comm/host_groups.hpp"
#include "comm/host_routes.hpp"
#include "gpu/transport/mailboxes.hpp"
#include "gpu/transport/peer_transport.hpp"
#include "gpu/transport/transport_trial.hpp"

namespace moraine::gpu {

namespace {

/// The ranks of this rank's host, and how they are numbered among themselves.
struct MyHost {
    MyHost(const Comm& all, const HostOfRank& host)
        : ranks(ranks_of_host(all, host)), number(numbers_on_host(host, all.rank())) {}

    std::unique_ptr<const Comm> ranks;
    std::vector<std::int32_t> number;  ///< of each rank of the run; -1: on another host
};

class MixedTransport final : public Transport {
  public:
    MixedTransport(const Comm& comm, std::shared_ptr<const MyHost> host, std::unique_ptr<Transport> between)
        : comm_(comm), host_(std::move(host)), within_(peer_transport(*host_->ranks)), between_(std::move(between)) {}

    const char* name() const override { return "mixed"; }
    std::byte* const* outgoing() const override { return pointers_.out() + within_->outgoing_set() * peers_; }
    const std::byte* const* incoming() const override {
        return pointers_.in() + (2 + within_->incoming_set()) * peers_;
    }

    void open(const std::vector<TransportPeer>& peers) override {
        std::vector<TransportPeer> near, far;
        for (const TransportPeer& peer : peers) {
            const std::int32_t number = host_->number[static_cast<std::size_t>(peer.rank)];
            if (number >= 0)
                near.push_back({number, peer.capacity_out, peer.capacity_in});
            else
                far.push_back(peer);
        }
        open_within(near);
        between_->open(far);  // waits for the device: no kernel reads the pointers that are replaced now
        peers_ = peers.size();
        const std::vector<std::byte*> out = on_host(between_->outgoing(), far.size());
        const std::vector<std::byte*> in = on_host(between_->incoming(), far.size());
        std::vector<std::byte*> all;
        for (int set = 0; set < 2; ++set) append(all, peers, within_->outgoing_pointers(set), out);
        for (int set = 0; set < 2; ++set) append(all, peers, within_->incoming_pointers(set), in);
        pointers_.assign(all);
    }

    void start(cudaStream_t stream) override {
        within_->start(stream);
        between_->start(stream);
    }
    void post() override { between_->post(); }
    /// What comes from other hosts first: for that alone the host may have to wait.
    void finish(cudaStream_t stream) override {
        between_->finish(stream);
        within_->finish(stream);
    }

  private:
    /// A host that cannot must not leave the others waiting for it.
    void open_within(const std::vector<TransportPeer>& near) {
        std::string wrong;
        try {
            within_->open(near);
        } catch (const MachineError& e) {
            wrong = e.what();
        }
        comm_.agree_no_error<MachineError>(wrong);
    }

    static std::vector<std::byte*> on_host(const std::byte* const* array, std::size_t n) {
        std::vector<std::byte*> pointers(n);
        if (n > 0)
            check(cudaMemcpy(pointers.data(), array, n * sizeof(std::byte*), cudaMemcpyDeviceToHost),
                  "Reading where messages go");
        return pointers;
    }

    /// Pointers in the order of `peers`.
    void append(std::vector<std::byte*>& all, const std::vector<TransportPeer>& peers,
                const std::vector<std::byte*>& near, const std::vector<std::byte*>& far) const {
        std::size_t n = 0, f = 0;
        for (const TransportPeer& peer : peers)
            all.push_back(host_->number[static_cast<std::size_t>(peer.rank)] >= 0 ? near[n++] : far[f++]);
    }

    const Comm& comm_;
    std::shared_ptr<const MyHost> host_;
    std::unique_ptr<TwoSetTransport> within_;
    std::unique_ptr<Transport> between_;
    std::size_t peers_ = 0;
    PointerArray pointers_;  ///< outgoing of both sets, incoming of both: by peer
};

class MixedTransports final : public TransportFactory {
  public:
    MixedTransports(const Comm& comm, const HostOfRank& host)
        : comm_(comm), host_(std::make_shared<const MyHost>(comm, host)), hosts_(host_count(host)) {
        std::string why_not;
        for (const TransportEntry& entry : transports()) {
            if (entry.name == "peer" || entry.name == "mixed") continue;
            if ((between_ = tried_transport(comm, entry, why_not))) return;
        }
        throw MachineError("No transport works between hosts (" + why_not + "). Is the network in order?");
    }

    const char* name() const override { return "mixed"; }
    std::string description() const override {
        return "mixed: peer within " + std::to_string(hosts_) + " hosts, " + between_->name() + " between";
    }
    std::unique_ptr<Transport> make(int tag) const override {
        return std::make_unique<MixedTransport>(comm_, host_, between_->make(tag));
    }

  private:
    const Comm& comm_;
    std::shared_ptr<const MyHost> host_;
    std::int32_t hosts_;
    std::unique_ptr<TransportFactory> between_;
};

}  // namespace

std::string mixed_obstacle(const Comm& comm) {
    const HostOfRank host = find_hosts(comm);
    if (host_count(host) == 1) return "the ranks are on one host";
    return host_count(host) == comm.size() ? "no two ranks are on one host" : "";
}

std::unique_ptr<TransportFactory> mixed_transports(const Comm& comm) {
    return std::make_unique<MixedTransports>(comm, find_hosts(comm));
}

}  // namespace moraine::gpu
