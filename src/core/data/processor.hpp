#pragma once
// What is compiled for the processor at hand: the widest register, and entries of which there are two.
//
// The transfers and the laws are compiled a second time for AVX-512 (CMakeLists.txt), and a run takes those where the
// processor has it (kernel_choice.cpp). Both do the same operations lane by lane: the bits do not depend on it. Inline
// functions and templates, of the standard library too, then exist twice under one name, and a linker that kept the
// wider copy would stop older processors. So the objects of AVX-512 are made into one, in which every name is local but
// those of the entries. A namespace of its own would not do that for std.

namespace moraine {

/// Bytes of the widest register that this file is compiled for.
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
inline constexpr int register_bytes = 64;
#elif defined(__AVX2__)
inline constexpr int register_bytes = 32;
#else
inline constexpr int register_bytes = 16;
#endif

/// The entry of this compilation.
#if defined(MORAINE_FOR_AVX512)
#define MORAINE_ENTRY(name) name##_avx512
#else
#define MORAINE_ENTRY(name) name##_any
#endif

/// Whether this run uses AVX-512: it was compiled, the processor and the system have it, and the environment does not
/// say MORAINE_AVX512=0. Not collective: ranks may differ.
bool uses_avx512();

}  // namespace moraine
