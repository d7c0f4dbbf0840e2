#include "gpu/transport/transport.hpp"

#include <algorithm>

#include "comm/transport_names.hpp"
#include "core/data/error.hpp"
#include "gpu/transport/mixed_transport.hpp"
#include "gpu/transport/mpi_transport.hpp"
#include "gpu/transport/nccl_transport.hpp"
#include "gpu/transport/peer_transport.hpp"
#include "gpu/transport/transport_trial.hpp"

namespace moraine::gpu {

namespace {

/// Where names become objects. A new transport: CONTRIBUTING.md.
constexpr TransportEntry entries[] = {
    {"peer", peer_obstacle, peer_transports}, {"mixed", mixed_obstacle, mixed_transports},
    {"nccl", nccl_obstacle, nccl_transports}, {"mpi", mpi_obstacle, mpi_transports},
    {"host", host_obstacle, host_transports},
};
static_assert(std::ranges::equal(entries, transport_names, {}, &TransportEntry::name), "one list, one order");

std::unique_ptr<TransportFactory> first_that_works(const Comm& comm, std::string& message) {
    const TransportEntry& last = entries[std::size(entries) - 1];
    std::string why_not, passed_over;
    for (const TransportEntry& entry : std::span(entries).first(std::size(entries) - 1)) {
        const std::string name(entry.name);
        if (std::unique_ptr<TransportFactory> factory = tried_transport(comm, entry, why_not)) {
            message = "messages by " + factory->description() + " (tried and right" + passed_over + ")";
            return factory;
        }
        passed_over += "; not " + name + ": " + why_not;
    }
    message = "messages by " + std::string(last.name) + " (" + passed_over.substr(2) + ")";
    return last.make(comm);
}

}  // namespace

std::span<const TransportEntry> transports() {
    return entries;
}

std::unique_ptr<TransportFactory> choose_transport(const Comm& comm, const std::string& wanted, std::string& message) {
    if (wanted == "auto") return first_that_works(comm, message);
    const auto entry = std::ranges::find(entries, wanted, &TransportEntry::name);
    std::string why_not = "no such transport";
    std::unique_ptr<TransportFactory> factory =
        entry == std::end(entries) ? nullptr : tried_transport(comm, *entry, why_not);
    if (!factory) throw InputError("--transport " + wanted + " cannot be had (" + why_not + "). Use --transport auto?");
    message = "messages by " + factory->description() + " (--transport)";
    return factory;
}

}  // namespace moraine::gpu
