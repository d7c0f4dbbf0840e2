#pragma once
// The kernels of two steps as a graph, whose dt a kernel of it sets (gpu/kernels/lead/decide.hpp): two, because
// lists have two places, and after two steps they are where they were.
//
// It is captured from the same launches that the host makes without a lead. Memory is allocated once: graphs are
// captured while another one runs, and freeing memory waits for the whole device.

#include <cuda_runtime.h>

#include <functional>
#include <utility>
#include <vector>

#include "gpu/kernels/lead/decide.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

/// A launch in a step and what it takes. In order.
struct LeadLaunch {
    bool beside = false;    ///< concurrent with the decision of its step; that of the step before switches it off
    int dt_parameter = -1;  ///< the parameter that dt is in; -1: it takes none
    std::size_t dt = 0;     ///< where in it [bytes]
    std::size_t gravity_impulse = 0;  ///< the same; 0: it takes none
    std::size_t least_size = 0;       ///< of that parameter
};

class LeadGraph {
  public:
    static constexpr int steps = 2;

    LeadGraph();
    LeadGraph(const LeadGraph&) = delete;
    LeadGraph& operator=(const LeadGraph&) = delete;
    ~LeadGraph() { forget(), bury(); }

    /// Whether this driver has what it needs.
    static bool is_possible();

    /// step(behind, stream) launches one step: the decision, then what `launches` says. `stream`: not that of the
    /// steps, and not blocking. Synchronous with it alone.
    void capture(const std::vector<LeadLaunch>& launches, cudaStream_t stream,
                 const std::function<void(const LeadNodes&)>& step);
    void launch(cudaStream_t stream) const { check(cudaGraphLaunch(run_, stream), "Launching steps"); }
    void forget();
    /// To free graphs waits for the whole device: they are kept until this is called, or there are many.
    void bury();

    /// What was captured holds for these pointers and numbers.
    bool holds(const std::vector<std::uint64_t>& key) const { return run_ && key == key_; }
    void set_key(std::vector<std::uint64_t> key) { key_ = std::move(key); }

    const cudaGraphDeviceNode_t* nodes() const { return nodes_.data(); }
    int node_count() const { return node_count_; }

  private:
    LeadNodes behind(int step, const std::vector<LeadLaunch>& launches) const;

    cudaGraph_t graph_ = nullptr;
    cudaGraphExec_t run_ = nullptr;
    Array<LeadTarget> targets_;
    Array<cudaGraphDeviceNode_t> nodes_;
    int node_count_ = 0;
    std::vector<std::pair<cudaGraph_t, cudaGraphExec_t>> old_;
    std::vector<std::uint64_t> key_;
};

}  // namespace moraine::gpu
