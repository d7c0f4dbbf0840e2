#include <doctest/doctest.h>

#include "balance/trigger.hpp"
#include "core/data/error.hpp"

using namespace moraine;

namespace {

BalanceSpec spec_of(Trigger rule, int interval = 50, const char* partitioner = "morton") {
    BalanceSpec spec;
    spec.trigger = rule;
    spec.interval = interval;
    spec.partitioner = partitioner;
    return spec;
}

RepartitionTrigger made(const BalanceSpec& spec) {
    return {spec, *make_partitioner(spec, Layout{2, {8, 8, 1}}, 4)};
}

/// 4 ranks, 4000 particles: max/mean = max / 1000.
TriggerInput loads(std::int64_t now, std::int64_t plan) {
    TriggerInput in;
    in.step = 100;
    in.now = {now, 4000, 4};
    in.plan = {plan, 4000, 4};
    return in;
}

}  // namespace

TEST_CASE("never means never") {
    const auto trigger = made(spec_of(Trigger::never));
    CHECK_FALSE(trigger.is_due(50));
    CHECK_FALSE(trigger.needs_plan({4000, 4000, 4}));
    CHECK_FALSE(trigger.decide(loads(4000, 1000)).repartition);
}

TEST_CASE("every N steps repartitions at each multiple of N, also a balanced flow") {
    const auto trigger = made(spec_of(Trigger::every, 10));
    std::vector<int> due;
    for (int step = 0; step < 35; ++step)
        if (trigger.is_due(step)) due.push_back(step);
    CHECK(due == std::vector<int>{10, 20, 30});
    CHECK(trigger.needs_plan({1000, 4000, 4}));
    CHECK(trigger.decide(loads(1000, 1000)).repartition);
}

TEST_CASE("the threshold rule repartitions above the threshold and not at it") {
    const auto trigger = made(spec_of(Trigger::threshold));
    CHECK(trigger.is_due(100));
    CHECK_FALSE(trigger.is_due(99));
    CHECK_FALSE(trigger.needs_plan({1050, 4000, 4}));
    CHECK_FALSE(trigger.decide(loads(1050, 1000)).repartition);
    CHECK(trigger.needs_plan({1051, 4000, 4}));
    CHECK(trigger.decide(loads(1051, 1000)).repartition);
    CHECK(std::string(trigger.decide(loads(1050, 1000)).reason) == "balanced");
}

TEST_CASE("a plan that hardly improves on what there is is refused by the threshold rule") {
    const auto trigger = made(spec_of(Trigger::threshold));
    CHECK_FALSE(trigger.decide(loads(1500, 1500)).repartition);  // one huge block: nothing to be gained
    CHECK_FALSE(trigger.decide(loads(1500, 1600)).repartition);
    CHECK_FALSE(trigger.decide(loads(1500, 1460)).repartition);  // 8 % of the excess
    CHECK(trigger.decide(loads(1500, 1440)).repartition);        // 12 %
    CHECK(std::string(trigger.decide(loads(1500, 1460)).reason) == "no better plan");
}

TEST_CASE("the planned rule waits until the growth of the loss has cost as much as the migration") {
    const auto trigger = made(spec_of(Trigger::planned));
    CHECK(trigger.needs_plan({1001, 4000, 4}));
    // the loss grows by 1 ms in each step from 5 ms that no plan removes: tau u - U = tau^2 / 2 ms
    std::int64_t first = 0;
    TriggerInput in = loads(1100, 1000);
    in.last_repartition = 1000;
    in.migration = 0.7999;
    for (std::int64_t tau = 1; tau < 100 && first == 0; ++tau) {
        in.step = in.last_repartition + tau;
        in.loses = 0.005 + 0.001 * static_cast<double>(tau);
        in.lost += 0.005 + 0.001 * (static_cast<double>(tau) - 0.5);
        if (trigger.decide(in).repartition) first = tau;
    }
    CHECK(first == 40);
}

TEST_CASE("no plan is made before the growth of the loss has cost what the smallest migration takes") {
    const auto planned = made(spec_of(Trigger::planned));
    TriggerInput in = loads(1100, 1000);
    in.step = 100;
    in.loses = 1e-4;  // 10 ms since the start, at this rate
    in.lost = 1e-2 - 0.99 * host_moves.start;
    CHECK_FALSE(planned.may_pay(in));
    in.migration = host_moves.start;  // of a plan that moves next to nothing
    CHECK_FALSE(planned.decide(in).repartition);
    in.lost = 1e-2 - 1.01 * host_moves.start;
    CHECK(planned.may_pay(in));
    CHECK(planned.decide(in).repartition);
    in.lost = 1e-2;
    CHECK(made(spec_of(Trigger::threshold)).may_pay(in));
}

TEST_CASE("the planned rule never answers to a loss that does not grow") {
    const auto trigger = made(spec_of(Trigger::planned));
    TriggerInput in = loads(1300, 1200);
    in.loses = 0.25;
    in.migration = 1e-6;
    for (in.step = 0; in.step < 1000; ++in.step) {
        in.lost = in.loses * static_cast<double>(in.step);
        REQUIRE_FALSE(trigger.decide(in).repartition);
    }
}

TEST_CASE("the planned rule refuses a plan that is no better, even if it costs nothing") {
    const auto trigger = made(spec_of(Trigger::planned));
    TriggerInput in = loads(1300, 1300);
    in.loses = 1;
    CHECK_FALSE(trigger.decide(in).repartition);
    in.plan.max = 1299;
    CHECK(trigger.decide(in).repartition);
}

TEST_CASE("the planned rule keeps what the planner would keep") {
    const auto trigger = made(spec_of(Trigger::planned));
    TriggerInput in = loads(1300, 1299);
    in.loses = 1;
    in.kind = PlanKind::keep;
    CHECK_FALSE(trigger.decide(in).repartition);
    CHECK(std::string(trigger.decide(in).reason) == "cheaper to keep");
}

TEST_CASE("the planner reckons with the time since the last repartition, and at least with an interval") {
    TriggerInput in = loads(1300, 1000);
    in.step = 1000;
    in.last_repartition = 700;
    CHECK(made(spec_of(Trigger::threshold, 50)).costs(in, 1e-7).steps == 300);
    CHECK(made(spec_of(Trigger::every, 400)).costs(in, 1e-7).steps == 400);
}

TEST_CASE("only the planned rule may keep and reckons with measured time, so that other runs repeat themselves") {
    TriggerInput in = loads(1250, 1000);
    in.slowest = 0.5;
    for (Trigger rule : {Trigger::every, Trigger::threshold}) {
        auto trigger = made(spec_of(rule));
        trigger.learn(0.1, 0.9);
        CHECK_FALSE(trigger.costs(in, 1e-7).may_keep);
        CHECK(trigger.costs(in, 1e-7).step == 1e-7);
        CHECK(trigger.costs(in, 1e-7).move.particle == host_moves.particle);
    }
    const auto planned = made(spec_of(Trigger::planned));
    CHECK(planned.costs(in, 1e-7).may_keep);
    CHECK(planned.costs(in, 1e-7).step * 1250 == doctest::Approx(0.5));
    in.slowest = 0;
    CHECK(planned.costs(in, 1e-7).step == 1e-7);
}

TEST_CASE("migrations that take longer than predicted make the next prediction longer") {
    auto planned = made(spec_of(Trigger::planned));
    const TriggerInput in = loads(1250, 1000);
    planned.learn(0.1, 0.3);
    CHECK(planned.costs(in, 1e-7).move.start / host_moves.start == doctest::Approx(2));
    CHECK(planned.costs(in, 1e-7).move.particle / host_moves.particle == doctest::Approx(2));
    planned.learn(0, 1);  // nothing moved: nothing to learn
    CHECK(planned.costs(in, 1e-7).move.particle / host_moves.particle == doctest::Approx(2));
    planned.learn(0.1, 0.1);  // as long as predicted
    CHECK(planned.costs(in, 1e-7).move.particle / host_moves.particle == doctest::Approx(2));
    for (int k = 0; k < 30; ++k) planned.learn(1, 1e6);
    CHECK(planned.costs(in, 1e-7).move.particle <= 100 * host_moves.particle);
}

TEST_CASE("a static partitioner ignores the trigger, and says so once") {
    for (Trigger rule : {Trigger::every, Trigger::threshold, Trigger::planned})
        for (const char* name : {"slabs", "slabs-initial", "cartesian"}) {
            const auto trigger = made(spec_of(rule, 1, name));
            TriggerInput in = loads(4000, 1000);
            in.loses = 1;
            CHECK_FALSE(trigger.is_due(1));
            CHECK_FALSE(trigger.needs_plan(in.now));
            CHECK_FALSE(trigger.decide(in).repartition);
            CHECK(trigger.notice() == "balance.trigger is ignored (partitioner " + std::string(name) + " is static).");
        }
    CHECK(made(spec_of(Trigger::never, 50, "slabs")).notice().empty());
    CHECK(made(spec_of(Trigger::threshold)).notice().empty());
}

TEST_CASE("a single rank never repartitions by threshold or plan") {
    TriggerInput in;
    in.step = 50;
    in.now = in.plan = {4000, 4000, 1};
    CHECK_FALSE(made(spec_of(Trigger::threshold)).decide(in).repartition);
    CHECK_FALSE(made(spec_of(Trigger::planned)).decide(in).repartition);
}

TEST_CASE("an interval or a threshold that makes no sense is refused") {
    CHECK_THROWS_AS(made(spec_of(Trigger::every, 0)), InputError);
    BalanceSpec spec = spec_of(Trigger::threshold);
    spec.threshold = 0.9;
    CHECK_THROWS_WITH_AS(made(spec), "balance.threshold = 0.9 (max/mean is never below 1). Use 1.05?", InputError);
}
