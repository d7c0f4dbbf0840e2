#include <doctest/doctest.h>

#include <cstdlib>
#include <string_view>

#include "core/data/processor.hpp"
#include "core/transfer/kernel_list.hpp"

using namespace moraine;

TEST_CASE("quadratic transfers are those for AVX-512 where the run uses it, and others are not") {
    for (bool affine : {false, true}) {
        const auto chosen = choose_kernels<double, 3>(moraine::Shape::quadratic, affine);
        const auto any = transfer_kernels_any<double, 3, Quadratic>(affine);
        CHECK((chosen.g2p != any.g2p) == uses_avx512());
        CHECK((chosen.p2g != any.p2g) == uses_avx512());
        const auto cubic = choose_kernels<float, 2>(moraine::Shape::cubic, affine);
        CHECK((cubic.g2p == transfer_kernels_any<float, 2, Cubic>(affine).g2p));
    }
}

TEST_CASE("MORAINE_AVX512=0 keeps a run from AVX-512") {
    const char* words = std::getenv("MORAINE_AVX512");
    if (words && std::string_view(words) == "0") CHECK(!uses_avx512());
}
