#pragma once
// Headers that travel in the program, as they were when it was built, for what is compiled at run time: a run needs no
// source tree, and what it compiles always fits its own code. The build writes them (bundle_sources.cpp).

#include <cstdint>
#include <vector>

namespace moraine {

struct SourceFile {
    const char* name;  ///< as an #include names it
    const char* text;
};

struct SourceBundle {
    std::vector<SourceFile> files;
    std::uint64_t hash;  ///< of names and texts
};

/// Of name, zero, text, zero, ...
SourceBundle read_bundle(const char* begin, const char* end);

/// What a law in a file may include (law_file.hpp).
const SourceBundle& law_sources();

}  // namespace moraine

/// Puts a bundle's file into the program, between two names.
#define MORAINE_EMBED(name, file)                                                                             \
    asm(".section .rodata\n.global " #name "_begin\n.global " #name "_end\n" #name "_begin:\n.incbin \"" file \
        "\"\n" #name "_end:\n.byte 0\n.section .text\n");                                                     \
    extern "C" const char name##_begin[];                                                                     \
    extern "C" const char name##_end[]
