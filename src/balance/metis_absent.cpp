// In place of metis.cpp where the program is built without METIS: make_partitioner() refuses before it gets here.
#include "balance/metis.hpp"
#include "core/error.hpp"

namespace moraine {

bool metis_is_built() {
    return false;
}

std::vector<std::int32_t> metis_parts(const Layout&, std::span<const BlockLoad>, int) {
    throw InputError("balance.partitioner = \"metis\" (this program was built without METIS). Use hilbert?");
}

}  // namespace moraine
