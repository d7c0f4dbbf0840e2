#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "gpu/engine_pair.hpp"
#include "gpu/memory/pool_array.hpp"
#include "gpu/memory/stream.hpp"
#include "gpu/transport/stream_flags.hpp"

using namespace moraine;
using namespace moraine::test;

// In the middle of a run nobody waits for the whole device, as who frees its memory does: a stream that stands still
// would hold him. Between devices streams do stand still, for messages of the others.

namespace {

/// Stands until it is released; a guard does so after some seconds.
class StandingStream {
  public:
    StandingStream() {
        set_flag(0);
        gpu::wait_for_flag(flag_.device(), 1, stream_);
        guard_ = std::thread([this] {
            std::unique_lock lock(mutex_);
            if (!done_.wait_for(lock, std::chrono::seconds(3), [this] { return released_; })) late_ = true;
            set_flag(1);
        });
    }
    ~StandingStream() { release(); }
    /// Whether somebody waited for it until the guard came.
    bool release() {
        {
            const std::lock_guard lock(mutex_);
            released_ = true;
        }
        done_.notify_one();
        if (guard_.joinable()) guard_.join();
        stream_.wait();
        return late_;
    }

  private:
    void set_flag(std::uint32_t value) { *static_cast<volatile std::uint32_t*>(&flag_.host()) = value; }

    gpu::Stream stream_{gpu::Stream::Rank::apart};
    gpu::Pinned<std::uint32_t> flag_;
    std::mutex mutex_;
    std::condition_variable done_;
    bool released_ = false, late_ = false;
    std::thread guard_;
};

struct Growth {
    std::int64_t epochs = 0, steps = 0;
    bool waited = false;
};

/// Some epochs, and then as many while a stream stands still. The host makes dt: who makes graphs waits now and then.
Growth grow_while_standing(const Scene& scene, std::int64_t epochs) {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = choose_device("cuda", comm);
    Simulation<double, 2> sim(scene, comm, device_engine_maker<double, 2>(scene, comm, device));
    sim.seed();
    const auto advance_by = [&](std::int64_t more) {
        const std::int64_t until = sim.counts_so_far().epochs + more;
        while (sim.counts_so_far().epochs < until && sim.clock().time < scene.end) sim.step(), sim.balance();
    };
    advance_by(epochs);
    StandingStream standing;
    const std::int64_t epochs_before = sim.counts_so_far().epochs, steps_before = sim.clock().step;
    advance_by(epochs);
    const bool waited = standing.release();
    return {sim.counts_so_far().epochs - epochs_before, sim.clock().step - steps_before, waited};
}

}  // namespace

TEST_CASE("who frees device memory waits for the whole device, who gives it back to the pool does not") {
    gpu::Stream stream;
    const std::vector<int> few(1000, 1), many(3'000'000, 2);
    gpu::Array<int> array;
    gpu::PoolArray<int> pooled;
    array.assign(few, stream), pooled.assign(few, stream);
    stream.wait();
    {
        StandingStream standing;
        pooled.assign(many, stream);
        stream.wait();
        CHECK(!standing.release());
        CHECK(pooled.host() == many);
    }
    {
        StandingStream standing;
        array.assign(many, stream);
        CHECK(standing.release());
    }
}

TEST_CASE("a flow that spreads over many epochs waits for the whole device in none of them") {
    const Scene scene = input("slurry_runout", {"domain.cell=0.02", "time.end=0.6"});
    const Growth growth = grow_while_standing(scene, 10);
    MESSAGE(growth.epochs << " epochs, " << growth.steps << " steps");
    CHECK(growth.epochs == 10);
    CHECK(!growth.waited);
}
