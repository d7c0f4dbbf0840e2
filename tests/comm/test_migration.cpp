#include "comm/migration.hpp"
#include "comm/swarm.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Case;
using moraine::test::fraction;
using moraine::test::Swarm;

namespace {

/// Random walks of up to 0.95 cells a step on all ranks and on one; a new epoch every third step.
template <class Real, int Dim>
void walks_as_on_one_rank(const Scene& scene, std::uint64_t walkers, bool open) {
    Swarm<Real, Dim> swarm(MPI_COMM_WORLD, scene), alone(MPI_COMM_SELF, scene);
    const auto settle = [&](auto& c) {
        c.settle(walkers, [&](std::uint64_t id, int a) {
            const double length = scene.max[static_cast<std::size_t>(a)];
            return length * fraction(mix(mix(id) + static_cast<unsigned>(a)));
        });
    };
    settle(swarm);
    settle(alone);
    REQUIRE(swarm.rows() == alone.rows());
    for (std::uint64_t n = 1; n <= 15; ++n) {
        const auto displacement = [n](std::uint64_t id, int a) {
            return 1.9 * fraction(mix(mix(id ^ n << 32) + static_cast<unsigned>(a))) - 0.95;
        };
        const auto leaves = [&](std::uint64_t id) { return open && mix(~id ^ n << 32) % 60 == 0; };
        swarm.step(displacement, leaves);
        alone.step(displacement, leaves);
        REQUIRE(swarm.rows() == alone.rows());
        REQUIRE(swarm.comm.sum(swarm.gone) == alone.gone);
        REQUIRE(alone.patch.count() + alone.gone == static_cast<std::int64_t>(walkers));
        if (n % 3 == 0) {
            swarm.shuffle(n);
            alone.shuffle(n);
            REQUIRE(swarm.rows() == alone.rows());
        }
    }
    if (open) CHECK(alone.gone > 0);
}

}  // namespace

TEST_CASE_TEMPLATE("random walkers are binned on any number of ranks as on one, to the bit", C, Case<float, 2>,
                   Case<double, 2>, Case<float, 3>, Case<double, 3>) {
    constexpr int dim = C::dim;
    for (bool open : {false, true}) {
        CAPTURE(open);
        walks_as_on_one_rank<typename C::Real, dim>(test::periodic_scene(dim, 3, 4, 3), 1500, open);
        walks_as_on_one_rank<typename C::Real, dim>(test::periodic_scene(dim, 1, 2, 1), 300, open);
        walks_as_on_one_rank<typename C::Real, dim>(test::periodic_scene(dim, 2, 2, 2), 300, open);
        walks_as_on_one_rank<typename C::Real, dim>(test::periodic_scene(dim, 9, 7, 5), 60, open);
    }
}

TEST_CASE_TEMPLATE("more outgoing particles than a message has capacity for follow in a second one and none is lost", C,
                   Case<float, 2>, Case<double, 3>) {
    constexpr int dim = C::dim;
    using Real = typename C::Real;
    const Scene scene = test::periodic_scene(dim, 4, 4, 4);
    Swarm<Real, dim> swarm(MPI_COMM_WORLD, scene), alone(MPI_COMM_SELF, scene);
    const auto settle = [](auto& c) {  // in the last cells of their blocks along x
        c.settle(6000, [](std::uint64_t id, int a) {
            const double f = fraction(mix(mix(id) + static_cast<unsigned>(a)));
            return a == 0 ? 4 * std::floor(4 * f) + 3.2 + 0.1 * fraction(mix(id)) : 4 + 3 * f;
        });
    };
    settle(swarm);
    settle(alone);
    bool overflow = false;
    for (int n = 0; n < 5; ++n) {
        std::int64_t before = swarm.migration->crossed();
        swarm.step([](std::uint64_t, int a) { return a == 0 ? 0.9 : 0; }, [](std::uint64_t) { return false; });
        alone.step([](std::uint64_t, int a) { return a == 0 ? 0.9 : 0; }, [](std::uint64_t) { return false; });
        REQUIRE(swarm.rows() == alone.rows());
        std::int64_t capacity = 0;
        for (const PeerHalo& peer : swarm.patch.tables().peers)
            capacity += 32 * static_cast<std::int64_t>(peer.send.block.size());
        overflow = overflow || swarm.migration->crossed() - before > capacity;
        if (n == 1 || n == 3) {
            swarm.shuffle(static_cast<std::uint64_t>(n));
            alone.shuffle(static_cast<std::uint64_t>(n));
            REQUIRE(swarm.rows() == alone.rows());
        }
    }
    if (swarm.comm.size() > 1) CHECK(swarm.comm.sum(std::int64_t(overflow)) > 0);
}

TEST_CASE("what crossed is counted and its slots are used again") {
    const Scene scene = test::periodic_scene(2, 4, 4, 1);
    Swarm<double, 2> swarm(MPI_COMM_WORLD, scene);
    swarm.settle(2000, [](std::uint64_t id, int a) { return 16 * fraction(mix(mix(id) + static_cast<unsigned>(a))); });
    const std::int64_t start = swarm.comm.sum(static_cast<std::int64_t>(swarm.patch.particles.size()));
    CHECK(start == 2000);
    for (int n = 0; n < 12; ++n) {
        const double there = n % 2 ? -0.9 : 0.9;
        swarm.step([there](std::uint64_t, int) { return there; }, [](std::uint64_t) { return false; });
    }
    const std::int64_t crossed = swarm.comm.sum(swarm.migration->crossed());
    if (swarm.comm.size() == 1)
        CHECK(crossed == 0);
    else
        CHECK(crossed > 500);
    CHECK(swarm.comm.sum(swarm.patch.count()) == 2000);
    // There and back again: no more slots than one round of incoming particles needed at most.
    CHECK(swarm.comm.sum(static_cast<std::int64_t>(swarm.patch.particles.size())) <= 2000 + crossed / 4);
}
