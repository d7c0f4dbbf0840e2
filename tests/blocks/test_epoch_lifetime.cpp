#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "blocks/epoch_lifetime.hpp"
#include "core/data/hash.hpp"

using namespace moraine;
using State = EpochLifetime::State;

namespace {

/// In [0, 1).
double fraction(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

}  // namespace

TEST_CASE("new tables are unbinned for one step, whatever that step says of the tables before") {
    EpochLifetime epoch;
    CHECK(epoch.state() == State::unbinned);
    epoch.step(true, 0.25);
    CHECK(epoch.state() == State::clear);
    epoch.step(true, 0.25);
    CHECK(epoch.state() == State::in_guard_layer);
    epoch.step(false, 0.25);
    CHECK(epoch.state() == State::clear);
    epoch.begin();
    CHECK(epoch.state() == State::unbinned);
}

TEST_CASE(
    "steps count while somebody is in the guard layer or nobody knows, and are forgotten when all are out of it") {
    EpochLifetime epoch;
    epoch.step(false, 0.75);  // unbinned: counts
    CHECK_FALSE(epoch.is_used_up());
    CHECK(epoch.ends_within(0.5));
    epoch.step(true, 0.5);
    CHECK(epoch.is_used_up());
    epoch.step(false, 0.5);
    CHECK_FALSE(epoch.is_used_up());
    CHECK_FALSE(epoch.ends_within(100));
    for (int k = 0; k < 1000; ++k) epoch.step(false, 0.9);  // a drop that spins in its place uses nothing up
    CHECK_FALSE(epoch.is_used_up());
}

TEST_CASE("tables that were made ahead begin as deep in the guard layer as somebody may have gone since") {
    EpochLifetime epoch;
    epoch.begin_next();
    epoch.step(true, 0.75);
    CHECK_FALSE(epoch.next_is_used_up());
    epoch.step(true, 0.75);
    CHECK(epoch.next_is_used_up());
    CHECK(epoch.next_is_stale());
    epoch.begin_made_ahead();  // 0.5 in
    CHECK_FALSE(epoch.ends_within(0.4));
    CHECK(epoch.ends_within(0.6));
    epoch.begin_next();
    epoch.begin_made_ahead();
    CHECK_FALSE(epoch.ends_within(100));
}

// Walkers on a line whose topology ends at 0: below 3 is the guard layer. What step n reached is told in step n + 1,
// and tables are renewed after it; nobody may be beyond the end by then.
TEST_CASE("nobody leaves the topology before its tables are used up, however he moves") {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        std::vector<double> x(8);
        for (std::size_t k = 0; k < x.size(); ++k) x[k] = 3 + 4 * fraction(mix(seed * 100 + k));
        const double largest = 0.02 + 0.97 * fraction(mix(seed));
        EpochLifetime epoch;
        bool was_in = false;
        double moved_before = 0;
        bool used_up = false;
        double least = 3;
        for (std::uint64_t n = 0; n < 2000 && !used_up; ++n) {
            epoch.step(was_in, moved_before);  // told of the step before
            double moved = 0;
            least = 3;
            for (std::size_t k = 0; k < x.size(); ++k) {
                const double random = 2 * fraction(mix(mix(seed) + 8 * n + k)) - 1;
                const double by = largest * (k == 0 && seed % 2 == 1 ? -1 : random);  // one goes straight to the end
                x[k] += by, moved = std::max(moved, std::fabs(by)), least = std::min(least, x[k]);
            }
            was_in = least < 3, moved_before = moved;
            used_up = epoch.is_used_up();
        }
        CAPTURE(seed);
        CHECK(least > 0);
        if (seed % 2 == 1) CHECK(used_up);
    }
}
