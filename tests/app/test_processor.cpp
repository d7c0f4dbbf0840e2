#include <doctest/doctest.h>

#include <string>

#include "app/processor_check.hpp"

using namespace moraine;

TEST_CASE("the first feature that is missing is named, and none where all are there") {
    CHECK(missing_feature(0, 0) == nullptr);
    CHECK(missing_feature(0b11, 0b111) == nullptr);
    CHECK(std::string(missing_feature(0b1100, 0b0111)) == "avx2");
    CHECK(std::string(missing_feature(0b1100, 0b0011)) == "avx");
}

TEST_CASE("the processor that runs the tests has what they were compiled for") {
    CHECK(missing_feature(processor_needs, processor_features()) == nullptr);
#ifdef __AVX2__
    CHECK((processor_needs & 1u << 3) != 0);
#endif
}
