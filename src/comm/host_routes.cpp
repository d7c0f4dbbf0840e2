#include "comm/host_routes.hpp"

namespace moraine {

std::vector<std::int32_t> numbers_on_host(std::span<const std::int32_t> host_of_rank, int rank) {
    std::vector<std::int32_t> number(host_of_rank.size(), -1);
    std::int32_t next = 0;
    for (std::size_t r = 0; r < number.size(); ++r)
        if (host_of_rank[r] == host_of_rank[static_cast<std::size_t>(rank)]) number[r] = next++;
    return number;
}

std::unique_ptr<const Comm> ranks_of_host(const Comm& comm, std::span<const std::int32_t> host_of_rank) {
    MPI_Comm here = MPI_COMM_NULL;
    MPI_Comm_split(comm.handle(), host_of_rank[static_cast<std::size_t>(comm.rank())], comm.rank(), &here);
    auto ranks = std::make_unique<const Comm>(here);
    MPI_Comm_free(&here);
    return ranks;
}

}  // namespace moraine
