// In place of zoltan.cpp where the program is built without Zoltan: make_partitioner() refuses before it gets here.
#include "balance/zoltan.hpp"
#include "core/error.hpp"

namespace moraine {

bool zoltan_is_built() {
    return false;
}

std::vector<std::int32_t> zoltan_parts(ZoltanMethod, const Layout&, int, std::span<const BlockLoad>, int) {
    throw InputError("balance.partitioner (this program was built without Zoltan). Use hilbert?");
}

}  // namespace moraine
