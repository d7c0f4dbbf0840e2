#include "comm/host_groups.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <map>
#include <numeric>
#include <string>

#include "core/data/error.hpp"

namespace moraine {
namespace {

/// Rank 0's words; empty: real hosts. Collective.
std::string pretended(const Comm& comm) {
    const char* words = std::getenv("MORAINE_PRETEND_HOSTS");
    return comm.broadcast(words ? words : "");
}

/// Hosts that have any names, by numbers in the order of their lowest ranks.
HostOfRank numbered_by_lowest(const std::vector<std::int64_t>& name) {
    std::map<std::int64_t, std::int32_t> number;
    HostOfRank host;
    for (const std::int64_t n : name)
        host.push_back(number.try_emplace(n, static_cast<std::int32_t>(number.size())).first->second);
    return host;
}

/// Numbers between commas; throws InputError.
std::vector<std::int64_t> numbers_of(const std::string& words) {
    std::vector<std::int64_t> numbers;
    const char* at = words.data();
    const char* const last = at + words.size();
    for (bool more = true; more;) {
        std::int64_t number = -1;
        const auto [end, error] = std::from_chars(at, last, number);
        more = end != last;
        if (error != std::errc() || number < 0 || (more && *end != ','))
            throw InputError("MORAINE_PRETEND_HOSTS = " + words +
                             " (a number of hosts, or the host of each rank as in 0,1,0,1). Unset it?");
        numbers.push_back(number);
        at = end + 1;
    }
    return numbers;
}

HostOfRank in_a_row(std::int64_t hosts, int ranks) {
    hosts = std::min<std::int64_t>(hosts, ranks);
    HostOfRank host;
    for (int r = 0; r < ranks; ++r) host.push_back(static_cast<std::int32_t>(r * hosts / ranks));
    return host;
}

HostOfRank pretended_hosts(const std::string& words, int ranks) {
    std::vector<std::int64_t> numbers = numbers_of(words);
    if (numbers.size() == 1 && numbers[0] > 0) return in_a_row(numbers[0], ranks);
    if (numbers.size() == 1 || numbers.size() < static_cast<std::size_t>(ranks))
        throw InputError("MORAINE_PRETEND_HOSTS = " + words + " (" +
                         (numbers.size() == 1 ? "no host holds " : "it names hosts for fewer than ") +
                         std::to_string(ranks) + " ranks). Unset it?");
    numbers.resize(static_cast<std::size_t>(ranks));
    return numbered_by_lowest(numbers);
}

/// The lowest rank of this rank's host. Collective.
std::int32_t lowest_here(const Comm& comm) {
    MPI_Comm here = MPI_COMM_NULL;
    MPI_Comm_split_type(comm.handle(), MPI_COMM_TYPE_SHARED, comm.rank(), MPI_INFO_NULL, &here);
    std::int32_t lowest = comm.rank();
    MPI_Allreduce(MPI_IN_PLACE, &lowest, 1, MPI_INT32_T, MPI_MIN, here);
    MPI_Comm_free(&here);
    return lowest;
}

}  // namespace

HostOfRank hosts_of(int ranks, int ranks_per_host) {
    HostOfRank host(static_cast<std::size_t>(ranks), 0);
    for (int r = 0; r < ranks && ranks_per_host > 0; ++r) host[static_cast<std::size_t>(r)] = r / ranks_per_host;
    return host;
}

std::int32_t host_count(std::span<const std::int32_t> host_of_rank) {
    return host_of_rank.empty() ? 1 : *std::max_element(host_of_rank.begin(), host_of_rank.end()) + 1;
}

std::vector<std::int32_t> ranks_by_host(std::span<const std::int32_t> host_of_rank) {
    std::vector<std::int32_t> ranks(host_of_rank.size());
    std::iota(ranks.begin(), ranks.end(), 0);
    std::stable_sort(ranks.begin(), ranks.end(),
                     [&](std::int32_t x, std::int32_t y) { return host_of_rank[x] < host_of_rank[y]; });
    return ranks;
}

HostOfRank find_hosts(const Comm& comm) {
    if (const std::string words = pretended(comm); !words.empty()) return pretended_hosts(words, comm.size());
    return numbered_by_lowest(comm.all_gather(std::vector<std::int64_t>{lowest_here(comm)}));
}

}  // namespace moraine
