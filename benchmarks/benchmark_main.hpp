#pragma once
// The main of a benchmark that runs simulations: MPI around it, and what went wrong as one line and exit code 1.

#include <fmt/format.h>
#include <mpi.h>

#include <cstdio>
#include <exception>

namespace moraine {

template <class F>
int benchmark_main(const char* name, int argc, char** argv, const F& benchmark) {
    MPI_Init(&argc, &argv);
    int code = 0;
    try {
        benchmark(argc, argv);
    } catch (const std::exception& e) {
        fmt::print(stderr, "{}: {}\n", name, e.what());
        code = 1;
    }
    MPI_Finalize();
    return code;
}

}  // namespace moraine
