#include <cuda_runtime.h>
#include <doctest/doctest.h>

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
    for (const auto& transports : all_transports(comm)) {
        CAPTURE(transports->name());
        const std::unique_ptr<gpu::Transport> transport = transports->make(21);
        for (std::size_t bytes : {std::size_t(16), std::size_t(4096), std::size_t(3) << 20, std::size_t(256)})
            CHECK(gpu::transport_trial(comm, *transport, bytes, 7) == "");
    }
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
