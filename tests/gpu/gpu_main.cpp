// The main function of tests that need a device: without one they are skipped, and say so.

#include <cuda_runtime.h>

#include <cstdio>

#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <mpi.h>

int main(int argc, char** argv) {
    int devices = 0;
    const cudaError_t answer = cudaGetDeviceCount(&devices);
    if (answer != cudaSuccess || devices == 0) {
        std::printf("SKIPPED: no CUDA device (%s). Run this test where there is one?\n", cudaGetErrorString(answer));
        return 77;
    }
    MPI_Init(&argc, &argv);
    const int failed = doctest::Context(argc, argv).run();
    MPI_Finalize();
    return failed;
}
