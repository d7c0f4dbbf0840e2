#include "compile/source_bundle.hpp"

#include <cstddef>
#include <cstring>

#include "core/data/hash.hpp"

MORAINE_EMBED(moraine_law_sources, MORAINE_LAW_BUNDLE);

namespace moraine {

SourceBundle read_bundle(const char* begin, const char* end) {
    SourceBundle bundle;
    bundle.hash = mix_bytes(0, reinterpret_cast<const std::byte*>(begin), static_cast<std::size_t>(end - begin));
    for (const char* at = begin; at < end;) {
        const char* text = at + std::strlen(at) + 1;
        bundle.files.push_back({at, text});
        at = text + std::strlen(text) + 1;
    }
    return bundle;
}

const SourceBundle& law_sources() {
    static const SourceBundle bundle = read_bundle(moraine_law_sources_begin, moraine_law_sources_end);
    return bundle;
}

}  // namespace moraine
