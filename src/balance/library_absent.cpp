// In place of zoltan.cpp and metis.cpp where the program is built without them: make_partitioner() refuses before it
// gets here.
#include "balance/metis.hpp"
#include "balance/zoltan.hpp"
#include "core/data/error.hpp"

namespace moraine {

#ifndef MORAINE_ZOLTAN
bool zoltan_is_built() {
    return false;
}

std::vector<std::int32_t> zoltan_parts(ZoltanMethod, const Layout&, int, std::span<const BlockLoad>, int) {
    throw InputError("balance.partitioner (this program was built without Zoltan). Use hilbert?");
}
#endif

#ifndef MORAINE_METIS
bool metis_is_built() {
    return false;
}

std::vector<std::int32_t> metis_parts(const Layout&, std::span<const BlockLoad>, int) {
    throw InputError("balance.partitioner = \"metis\" (this program was built without METIS). Use hilbert?");
}
#endif

}  // namespace moraine
