#include "gpu/transport/transport_trial.hpp"

#include <cstring>

#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

namespace {

/// Message of a round, of any length up to `most`.
std::vector<std::byte> message(int from, int to, int round, std::size_t most) {
    const std::size_t units = most / 16, k = static_cast<std::size_t>(7 * from + 3 * to + 5 * round);
    std::vector<std::byte> bytes(16 * (1 + k % std::max<std::size_t>(1, units)));
    const MessageHead head{bytes.size(), static_cast<std::uint64_t>(round)};
    std::memcpy(bytes.data(), &head, sizeof(head));
    for (std::size_t i = sizeof(head); i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 31 + k);
    return bytes;
}

/// Pointers of an array on the device.
std::vector<std::byte*> pointers(const std::byte* const* array, std::size_t n) {
    std::vector<std::byte*> p(n);
    if (n > 0) check(cudaMemcpy(p.data(), array, n * sizeof(std::byte*), cudaMemcpyDeviceToHost), "Trying a transport");
    return p;
}

std::string try_round(const Comm& comm, Transport& transport, const std::vector<TransportPeer>& peers, int round,
                      std::size_t bytes, const Stream& stream) {
    const std::vector<std::byte*> out = pointers(transport.outgoing(), peers.size());
    for (std::size_t k = 0; k < peers.size(); ++k) {
        const std::vector<std::byte> mine = message(comm.rank(), peers[k].rank, round, bytes);
        check(cudaMemcpyAsync(out[k], mine.data(), mine.size(), cudaMemcpyDefault, stream), "Trying a transport");
        stream.wait();
    }
    transport.start(stream);
    transport.post();
    transport.finish(stream);
    const std::vector<std::byte*> in = pointers(transport.incoming(), peers.size());
    std::string wrong;
    for (std::size_t k = 0; k < peers.size(); ++k) {
        const std::vector<std::byte> wanted = message(peers[k].rank, comm.rank(), round, bytes);
        std::vector<std::byte> come(wanted.size());
        check(cudaMemcpyAsync(come.data(), in[k], come.size(), cudaMemcpyDefault, stream), "Trying a transport");
        stream.wait();
        if (come != wanted) wrong = "a message from rank " + std::to_string(peers[k].rank) + " came garbled";
    }
    return wrong;
}

}  // namespace

std::string transport_trial(const Comm& comm, Transport& transport, std::size_t bytes, int rounds,
                            const ArePeers& are_peers) {
    std::vector<TransportPeer> peers;
    for (int r = 0; r < comm.size(); ++r)
        if (r != comm.rank() && (!are_peers || are_peers(r, comm.rank()))) peers.push_back({r, bytes, bytes});
    std::string wrong;
    try {
        transport.open(peers);
        const Stream stream;
        for (int round = 0; round < rounds && wrong.empty(); ++round)
            wrong = try_round(comm, transport, peers, round, bytes, stream);
    } catch (const MachineError& e) {
        wrong = e.what();
    }
    try {
        comm.agree_no_error<MachineError>(wrong);
    } catch (const MachineError& e) {
        wrong = e.what();
    }
    return wrong;
}

std::unique_ptr<TransportFactory> tried_transport(const Comm& comm, const TransportEntry& entry, std::string& why_not) {
    why_not = entry.obstacle(comm);
    if (!why_not.empty()) return nullptr;
    std::unique_ptr<TransportFactory> factory = entry.make(comm);
    const std::unique_ptr<Transport> transport = factory->make(90);
    why_not = transport_trial(comm, *transport, 4096, 4);
    return why_not.empty() ? std::move(factory) : nullptr;
}

}  // namespace moraine::gpu
