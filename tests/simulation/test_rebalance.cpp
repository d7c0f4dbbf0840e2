#include <doctest/doctest.h>

#include <numeric>

#include "simulation/rebalance.hpp"

using namespace moraine;
using State = Rebalance<2>::State;

namespace {

/// A row of 32 blocks of one particle each, of which `held_by` says the owner; no particle anywhere.
struct Row {
    static constexpr int blocks = 32;

    Comm comm{MPI_COMM_WORLD};
    Scene scene = row_scene();
    BalanceSpec& spec = scene.balance;
    DomainBlocks<2> domain{scene};
    std::unique_ptr<Partitioner> partitioner;
    std::unique_ptr<RepartitionTrigger> trigger;
    std::unique_ptr<NextEpoch<2>> next;
    std::unique_ptr<Rebalance<2>> rebalance;
    std::vector<std::int32_t> owner;

    /// All blocks begin with `first_owner`.
    Row(bool async, Trigger rule, std::int32_t first_owner) : owner(blocks, first_owner) {
        spec.trigger = rule;
        spec.interval = 40;
        partitioner = make_partitioner(spec, {2, {blocks, 1, 1}, {}, 3}, comm);
        trigger = std::make_unique<RepartitionTrigger>(spec, *partitioner);
        next = std::make_unique<NextEpoch<2>>(domain, Stencil{3, 1, 0.5}, comm.rank(),
                                              [](const BlockPosition<2>&) { return -1; });
        std::vector<OccupiedBlock> occupied;
        for (int b = 0; b < blocks; ++b) occupied.push_back({key_of(b), owner[static_cast<std::size_t>(b)]});
        next->make(occupied);
        rebalance = std::make_unique<Rebalance<2>>(spec, comm, *partitioner, *trigger, *next);
        rebalance->set_async(async);
    }

    static Key key_of(int b) { return Morton<2>::encode({b, 0}); }

    static Scene row_scene() {
        Scene s;
        s.dimensions = 2;
        s.cell = 1;
        s.min = {0, 0, 0}, s.max = {4.0 * blocks - 2, 2, 0};
        return s;
    }

    std::vector<BlockLoad> mine() const {
        std::vector<BlockLoad> loads;
        for (int b = 0; b < blocks; ++b)
            if (owner[static_cast<std::size_t>(b)] == comm.rank()) loads.push_back({key_of(b), 1, 1, comm.rank()});
        return loads;
    }

    void begin(std::int64_t step) {
        ImbalanceCheckInput input;
        input.times.step = step;
        input.most = 1000;
        input.unit = 1e-9;
        rebalance->begin(step, mine(), input);
    }

    /// Steps until it is due; what is agreed on in a step is of the step before. Returns the step.
    std::int64_t until_due(std::int64_t step) {
        for (; rebalance->state() != State::due; ++step) {
            const bool making = comm.max(next->is_ready() ? 0.0 : 1.0) > 0;
            rebalance->advance(step, making, false);
            REQUIRE(step < 1000);
        }
        return step - 1;
    }

    /// Own blocks that the tables have with a particle.
    int held(const EpochTables<2>& tables) const {
        int n = 0;
        for (int b = 0; b < blocks; ++b) n += tables.find_own(key_of(b)) >= 0 ? 1 : 0;
        return n;
    }
};

}  // namespace

TEST_CASE(
    "at once or asynchronously, a check goes from gathering over planning to due, and one rank's blocks are shared") {
    for (bool async : {true, false}) {
        CAPTURE(async);
        Row row(async, Trigger::threshold, 0);
        if (row.comm.size() == 1) return;
        CHECK(row.rebalance->state() == State::idle);
        CHECK(row.rebalance->steps_ahead() == (async ? Rebalance<2>::most_steps_ahead : 0));
        const std::int64_t step = 40 - row.rebalance->steps_ahead();
        row.begin(step);
        CHECK(row.rebalance->state() == State::gathering);
        CHECK(row.until_due(step) >= 40);
        const std::optional<EpochTables<2>> tables = row.rebalance->take();
        CHECK(row.rebalance->state() == State::idle);
        REQUIRE(tables);
        CHECK(row.comm.sum(static_cast<std::int64_t>(row.held(*tables))) == Row::blocks);
        CHECK(row.comm.max(double(row.held(*tables))) - row.comm.min(double(row.held(*tables))) <= 1);
        const ImbalanceCheck found = row.rebalance->take_check();
        CHECK(found.repartitioned);
        CHECK(found.reason == "threshold");
        CHECK(found.terms.now.imbalance() == row.comm.size());
        CHECK(row.rebalance->take_check().reason.empty());  // told once
    }
}

TEST_CASE("a plan is taken at the due step when all have planned, and at the latest before the next is wanted") {
    Row row(true, Trigger::threshold, 0);
    if (row.comm.size() == 1) return;
    row.rebalance->want(24);
    row.begin(24);
    for (std::int64_t step = 24; step < 63; ++step) {
        row.rebalance->advance(step, true, false);  // somebody has not planned
        REQUIRE(row.rebalance->is_under_way());
        REQUIRE(row.rebalance->state() != State::due);
    }
    row.rebalance->advance(63, true, false);
    CHECK(row.rebalance->state() == State::due);
    row.rebalance->take();

    row.begin(64);
    row.rebalance->advance(65, true, true);  // the epoch is used up: nobody can wait, not even for loads
    CHECK(row.rebalance->state() == State::due);
    CHECK(row.rebalance->take());
}

TEST_CASE("where all is balanced nothing moves, and what ends without loads is told, too") {
    Row row(true, Trigger::threshold, 0);
    for (int b = 0; b < Row::blocks; ++b) row.owner[static_cast<std::size_t>(b)] = b * row.comm.size() / Row::blocks;
    row.begin(24);
    row.until_due(24);
    CHECK_FALSE(row.rebalance->take());
    CHECK(row.rebalance->take_check().reason == "balanced");
    row.rebalance->skip({false, "not worth it", {}});
    CHECK(row.rebalance->state() == State::idle);
    CHECK(row.rebalance->take_check().reason == "not worth it");
}

TEST_CASE("one is wanted steps ahead of the interval, not alone, and not where the epoch ends meanwhile") {
    Row row(true, Trigger::threshold, 0);
    const bool alone = row.comm.size() == 1;
    EpochLifetime fresh, old;
    fresh.step(false, 0), fresh.step(false, 0);
    old.step(true, 0.4), old.step(true, 0.4);
    row.rebalance->want(23);
    CHECK_FALSE(row.rebalance->is_to_begin(23, fresh, 0.01));
    row.rebalance->want(24);
    CHECK(row.rebalance->is_to_begin(24, fresh, 0.01) == !alone);
    CHECK_FALSE(row.rebalance->is_to_begin(24, old, 0.01));  // 0.8 + 32 * 0.01 > 1
    CHECK(row.rebalance->is_to_begin(24, old, 0.001) == !alone);
    CHECK(row.rebalance->is_to_begin(64, old, 0.01) == !alone);  // an interval later in any case
    if (alone) return;
    row.begin(24);
    CHECK_FALSE(row.rebalance->is_to_begin(25, fresh, 0.01));  // one at a time
    row.until_due(24);
    row.rebalance->take();
    CHECK_FALSE(row.rebalance->is_to_begin(60, fresh, 0.01));  // until it is wanted again
    Row every(false, Trigger::every, 0);
    every.rebalance->want(40);
    CHECK(every.rebalance->is_to_begin(40, old, 0.5));
}

TEST_CASE("a run may end while its ranks plan: the thread is waited for, which plans with what goes away") {
    for (int k = 0; k < 200; ++k) {
        Row row(true, Trigger::every, 0);
        row.begin(24);
        while (row.rebalance->state() == State::gathering) row.rebalance->advance(25, true, false);
        row.rebalance.reset();
        CHECK(row.next->is_ready());
    }
}
