#include "io/deflate.hpp"

#include "core/data/error.hpp"

#if MORAINE_HAS_ZLIB
#include <zlib.h>
#endif

namespace moraine {

bool can_deflate() {
    return MORAINE_HAS_ZLIB;
}

#if MORAINE_HAS_ZLIB
std::vector<std::byte> deflated(std::span<const std::byte> bytes, std::size_t number_bytes) {
    const std::size_t numbers = bytes.size() / number_bytes;
    std::vector<std::byte> sorted(bytes.size());
    for (std::size_t k = 0; k < number_bytes; ++k)
        for (std::size_t n = 0; n < numbers; ++n) sorted[k * numbers + n] = bytes[n * number_bytes + k];
    uLongf size = compressBound(sorted.size());
    std::vector<std::byte> small(size);
    if (compress2(reinterpret_cast<Bytef*>(small.data()), &size, reinterpret_cast<const Bytef*>(sorted.data()),
                  sorted.size(), deflate_level) != Z_OK)
        throw MachineError("cannot compress an output (zlib failed). Leave output.compression out?");
    small.resize(size);
    small.shrink_to_fit();
    return small;
}
#else
std::vector<std::byte> deflated(std::span<const std::byte>, std::size_t) {
    throw MachineError("cannot compress an output (built without zlib). Leave output.compression out?");
}
#endif

}  // namespace moraine
