#include <doctest/doctest.h>

#include "core/data/block.hpp"

using namespace moraine;

namespace {

/// By the definition, axis by axis.
template <int Dim>
bool reaches(int cell, int code) {
    bool all = true;
    for (int a = 0; a < Dim; ++a, cell /= 4) {
        const int to = cell % 4 + Block<Dim>::offset(code, a);
        all = all && (Block<Dim>::offset(code, a) == 0 || to < 0 || to > 3);
    }
    return all;
}

template <int Dim>
void reach_is_that_of_the_definition() {
    for (int cell = 0; cell < Block<Dim>::cells; ++cell) {
        CAPTURE(cell);
        const std::uint32_t reach = Block<Dim>::reach(cell);
        for (int code = 0; code < Block<Dim>::offsets; ++code) CHECK((reach >> code & 1) == reaches<Dim>(cell, code));
        CHECK((reach >> Block<Dim>::offsets) == 0);
    }
}

}  // namespace

TEST_CASE("less than a cell leads from a cell to the blocks beside it, and to no other") {
    reach_is_that_of_the_definition<2>();
    reach_is_that_of_the_definition<3>();
}
