#include <cuda_runtime.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>

#include "gpu/memory/stream.hpp"
#include "gpu/transport/transport.hpp"
#include "gpu/transport/transport_trial.hpp"

using namespace moraine;

// One set of demands for all transports. Ranks take the devices in turn; several may share one.

namespace {

void take_device(const Comm& comm) {
    int devices = 0;
    gpu::check(cudaGetDeviceCount(&devices), "Counting devices");
    gpu::check(cudaSetDevice(comm.rank() % devices), "Choosing a device");
}

bool has_device_of_its_own(const Comm& comm) {
    int devices = 0;
    gpu::check(cudaGetDeviceCount(&devices), "Counting devices");
    return comm.size() <= devices;
}

/// MORAINE_PRETEND_HOSTS while it lives; nothing: the hosts that there are.
class PretendedHosts {
  public:
    explicit PretendedHosts(const char* hosts) {
        if (*hosts) setenv("MORAINE_PRETEND_HOSTS", hosts, 1);
    }
    PretendedHosts(const PretendedHosts&) = delete;
    PretendedHosts& operator=(const PretendedHosts&) = delete;
    ~PretendedHosts() { unsetenv("MORAINE_PRETEND_HOSTS"); }
};

/// Of four ranks or fewer: in a row, in turn, and one alone.
constexpr const char* host_groups[] = {"", "2", "0,1,0,1", "0,0,1,0"};

/// All that can be had here.
std::vector<std::unique_ptr<gpu::TransportFactory>> all_transports(const Comm& comm) {
    std::vector<std::unique_ptr<gpu::TransportFactory>> all;
    for (const gpu::TransportEntry& entry : gpu::transports())
        if (entry.obstacle(comm).empty()) all.push_back(entry.make(comm));
    return all;
}

}  // namespace

TEST_CASE("messages of any length arrive as they were sent, round after round, after every new opening") {
    const Comm comm(MPI_COMM_WORLD);
    take_device(comm);
    for (const char* hosts : host_groups) {
        const PretendedHosts pretended(hosts);
        for (const auto& transports : all_transports(comm)) {
            CAPTURE(hosts);
            CAPTURE(transports->name());
            const std::unique_ptr<gpu::Transport> transport = transports->make(21);
            for (std::size_t bytes : {std::size_t(16), std::size_t(4096), std::size_t(3) << 20, std::size_t(256)})
                CHECK(gpu::transport_trial(comm, *transport, bytes, 7) == "");
        }
    }
}

TEST_CASE("a rank may have peers on its host alone, on others alone, or none, and others at the next opening") {
    const Comm comm(MPI_COMM_WORLD);
    take_device(comm);
    for (const char* hosts : host_groups) {
        const PretendedHosts pretended(hosts);
        for (const auto& transports : all_transports(comm)) {
            CAPTURE(hosts);
            CAPTURE(transports->name());
            const std::unique_ptr<gpu::Transport> transport = transports->make(23);
            for (const unsigned pairs : {0x01u, 0x3fu, 0x02u, 0x20u, 0x12u, 0x00u, 0x2du, 0x3fu}) {
                CAPTURE(pairs);  // a bit for each pair of four ranks
                const auto are_peers = [&](int a, int b) {
                    const int low = std::min(a, b), high = std::max(a, b);
                    return (pairs >> (high * (high - 1) / 2 + low) & 1u) != 0;
                };
                CHECK(gpu::transport_trial(comm, *transport, 4096, 3, are_peers) == "");
            }
        }
    }
}

TEST_CASE("two transports of one kind do not take each other's messages") {
    const Comm comm(MPI_COMM_WORLD);
    take_device(comm);
    for (const char* hosts : host_groups) {
        const PretendedHosts pretended(hosts);
        for (const auto& transports : all_transports(comm)) {
            CAPTURE(hosts);
            CAPTURE(transports->name());
            const std::unique_ptr<gpu::Transport> one = transports->make(24), other = transports->make(25);
            for (int round = 0; round < 3; ++round) {
                CHECK(gpu::transport_trial(comm, *one, 4096, 1 + round) == "");
                CHECK(gpu::transport_trial(comm, *other, 256, 2) == "");
            }
        }
    }
}

TEST_CASE("hosts with several ranks each send by peer within and by another between, and auto says so") {
    const Comm comm(MPI_COMM_WORLD);
    take_device(comm);
    std::string message;
    bool peer_works = true;
    try {
        gpu::choose_transport(comm, "peer", message);
    } catch (const InputError&) {
        peer_works = false;
    }
    CHECK_THROWS_AS(gpu::choose_transport(comm, "mixed", message), InputError);  // one host
    if (comm.size() == 1) return;
    const PretendedHosts pretended("2");
    CHECK_THROWS_AS(gpu::choose_transport(comm, "peer", message), InputError);
    if (comm.size() == 2) CHECK_THROWS_AS(gpu::choose_transport(comm, "mixed", message), InputError);
    if (comm.size() == 2 || !peer_works) return;
    CHECK(std::string(gpu::choose_transport(comm, "auto", message)->name()) == "mixed");
    MESSAGE(message);
    CHECK(message.find("mixed: peer within 2 hosts, ") != std::string::npos);
    CHECK(message.find(" between") != std::string::npos);
    if (!has_device_of_its_own(comm)) CHECK(message.find("nccl between") == std::string::npos);
}

TEST_CASE("a message of more than 2 GiB arrives") {
    const Comm comm(MPI_COMM_WORLD);
    if (comm.size() != 2) return;
    take_device(comm);
    const std::size_t bytes = (std::size_t(9) << 28) + 4096;
    for (const auto& transports : all_transports(comm)) {
        CAPTURE(transports->name());
        const std::unique_ptr<gpu::Transport> transport = transports->make(22);
        transport->open({{1 - comm.rank(), bytes, bytes}});
        const gpu::Stream stream;
        const auto pointer = [](const std::byte* const* array) {
            std::byte* p = nullptr;
            gpu::check(cudaMemcpy(&p, array, sizeof(p), cudaMemcpyDeviceToHost), "Reading");
            return p;
        };
        std::byte* const out = pointer(transport->outgoing());
        const gpu::MessageHead head{bytes, 5};
        const std::uint64_t last = 0x1234567 + static_cast<std::uint64_t>(comm.rank());
        gpu::check(cudaMemcpyAsync(out, &head, sizeof(head), cudaMemcpyDefault, stream), "Writing");
        gpu::check(cudaMemcpyAsync(out + bytes - 8, &last, 8, cudaMemcpyDefault, stream), "Writing");
        transport->start(stream);
        transport->post();
        transport->finish(stream);
        std::uint64_t found = 0;
        gpu::check(cudaMemcpyAsync(&found, pointer(transport->incoming()) + bytes - 8, 8, cudaMemcpyDefault, stream),
                   "Reading");
        stream.wait();
        CHECK(found == 0x1234567 + static_cast<std::uint64_t>(1 - comm.rank()));
    }
}

TEST_CASE("what is asked for and cannot be had is refused, and auto finds something") {
    const Comm comm(MPI_COMM_WORLD);
    take_device(comm);
    std::string message;
    const std::unique_ptr<gpu::TransportFactory> found = gpu::choose_transport(comm, "auto", message);
    CHECK(found != nullptr);
    MESSAGE(message);
    CHECK(message.find(found->name()) != std::string::npos);
    for (const gpu::TransportEntry& entry : gpu::transports())
        if (!entry.obstacle(comm).empty())
            CHECK_THROWS_AS(gpu::choose_transport(comm, std::string(entry.name), message), InputError);
    CHECK_THROWS_AS(gpu::choose_transport(comm, "telex", message), InputError);
    if (!has_device_of_its_own(comm)) CHECK_THROWS_AS(gpu::choose_transport(comm, "nccl", message), InputError);
    CHECK(std::string(gpu::choose_transport(comm, "host", message)->name()) == "host");
}
