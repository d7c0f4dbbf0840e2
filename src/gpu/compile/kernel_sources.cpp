#include "gpu/compile/kernel_sources.hpp"

#include <cstddef>
#include <cstring>

#include "core/hash.hpp"

// Written by bundle_sources.cpp: name, zero, text, zero, ...
asm(R"(
    .section .rodata
    .global moraine_kernel_sources_begin
    .global moraine_kernel_sources_end
moraine_kernel_sources_begin:
    .incbin ")" MORAINE_KERNEL_BUNDLE R"("
moraine_kernel_sources_end:
    .byte 0
    .section .text
)");

extern "C" const char moraine_kernel_sources_begin[];
extern "C" const char moraine_kernel_sources_end[];

namespace moraine::gpu {

const std::vector<KernelSource>& kernel_sources() {
    static const std::vector<KernelSource> sources = [] {
        std::vector<KernelSource> all;
        for (const char* at = moraine_kernel_sources_begin; at < moraine_kernel_sources_end;) {
            const char* text = at + std::strlen(at) + 1;
            all.push_back({at, text});
            at = text + std::strlen(text) + 1;
        }
        return all;
    }();
    return sources;
}

std::uint64_t kernel_sources_hash() {
    static const std::uint64_t hash =
        mix_bytes(0, reinterpret_cast<const std::byte*>(moraine_kernel_sources_begin),
                  static_cast<std::size_t>(moraine_kernel_sources_end - moraine_kernel_sources_begin));
    return hash;
}

}  // namespace moraine::gpu
