#include "gpu/compile/kernel_sources.hpp"

MORAINE_EMBED(moraine_kernel_sources, MORAINE_KERNEL_BUNDLE);

namespace moraine::gpu {

const SourceBundle& kernel_sources() {
    static const SourceBundle bundle = read_bundle(moraine_kernel_sources_begin, moraine_kernel_sources_end);
    return bundle;
}

}  // namespace moraine::gpu
