#include "app/processor_check.hpp"

#include <unistd.h>

#include <cstring>

namespace moraine {
namespace {

constexpr const char* names[] = {"sse4.2", "popcnt",  "avx",      "avx2",     "fma",      "bmi",
                                 "bmi2",   "avx512f", "avx512vl", "avx512bw", "avx512dq", "avx512vnni"};
constexpr unsigned count = sizeof names / sizeof names[0];
constexpr int machine_failed = 4;  // an exit code of main

/// Standard error, without a library that may itself be compiled for another processor.
void say(const char* text) {
    if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
}

[[gnu::constructor(101)]] void check_processor() {
    const char* missing = missing_feature(processor_needs, processor_features());
    if (!missing) return;
    say("moraine: this processor cannot run the program (it has no ");
    say(missing);
    say("). Configure with -DMORAINE_MARCH= (empty: any processor), or on the machine that is to run it?\n");
    ::_exit(machine_failed);
}

}  // namespace

unsigned processor_features() {
    unsigned has = 0;
#if defined(__x86_64__)
    __builtin_cpu_init();
    const bool there[] = {__builtin_cpu_supports("sse4.2") != 0,   __builtin_cpu_supports("popcnt") != 0,
                          __builtin_cpu_supports("avx") != 0,      __builtin_cpu_supports("avx2") != 0,
                          __builtin_cpu_supports("fma") != 0,      __builtin_cpu_supports("bmi") != 0,
                          __builtin_cpu_supports("bmi2") != 0,     __builtin_cpu_supports("avx512f") != 0,
                          __builtin_cpu_supports("avx512vl") != 0, __builtin_cpu_supports("avx512bw") != 0,
                          __builtin_cpu_supports("avx512dq") != 0, __builtin_cpu_supports("avx512vnni") != 0};
    static_assert(sizeof there == count);
    for (unsigned k = 0; k < count; ++k) has |= there[k] ? 1u << k : 0u;
#endif
    return has;
}

const char* missing_feature(unsigned needs, unsigned has) {
    for (unsigned k = 0; k < 8 * sizeof needs; ++k)
        if (needs & ~has & 1u << k) return k < count ? names[k] : "instruction set that is known";
    return nullptr;
}

}  // namespace moraine
