#include "gpu/lead_graph.hpp"

#include <algorithm>
#include <stdexcept>

#include "gpu/compile/cuda_driver.hpp"

namespace moraine::gpu {

namespace {

constexpr std::size_t most_nodes = 96, most_targets = 112;  ///< of both steps
constexpr std::size_t most_old = 64;

int targets_of(const std::vector<LeadLaunch>& launches) {
    int n = 0;
    for (const LeadLaunch& l : launches) n += (l.dt_parameter >= 0 ? 1 : 0) + (l.gravity_impulse > 0 ? 1 : 0);
    return n;
}

/// The handle by which the device changes a kernel of the graph.
cudaGraphDeviceNode_t handle_of(cudaGraphNode_t node) {
    cudaLaunchAttributeValue value{};
    value.deviceUpdatableKernelNode.deviceUpdatable = 1;
    check(cudaGraphKernelNodeSetAttribute(node, cudaLaunchAttributeDeviceUpdatableKernelNode, &value),
          "Making a launch changeable");
    cudaLaunchAttributeValue made{};
    check(cudaGraphKernelNodeGetAttribute(node, cudaLaunchAttributeDeviceUpdatableKernelNode, &made),
          "Making a launch changeable");
    return made.deviceUpdatableKernelNode.devNode;
}

/// Where the parameter of a kernel begins in its arguments [bytes].
std::size_t place_of(cudaGraphNode_t node, const LeadLaunch& launch) {
    const Driver& driver = Driver::instance();  // the runtime does not know kernels that it has not loaded
    CUDA_KERNEL_NODE_PARAMS kernel{};
    check(driver.parameters_of_node(node, &kernel), "Looking at a launch");
    if (!kernel.func) check(driver.function_of_kernel(&kernel.func, kernel.kern), "Looking at a launch");
    std::size_t offset = 0, size = 0;
    check(driver.parameter(kernel.func, static_cast<std::size_t>(launch.dt_parameter), &offset, &size),
          "Looking at a launch");
    if (size < launch.least_size) throw std::logic_error("a kernel does not take what its launch says");
    return offset;
}

}  // namespace

LeadGraph::LeadGraph() {
    targets_.resize(most_targets);
    nodes_.resize(most_nodes);
}

bool LeadGraph::is_possible() {
    int driver = 0;
    check(cudaDriverGetVersion(&driver), "Asking for the driver");
    return driver >= 12040;
}

void LeadGraph::forget() {
    if (old_.size() >= most_old) bury();  // the last step of the present one may be under way
    if (graph_) old_.emplace_back(graph_, run_);
    run_ = nullptr;
    graph_ = nullptr;
    key_.clear();
}

void LeadGraph::bury() {
    for (const auto& [graph, run] : old_) {
        if (run) cudaGraphExecDestroy(run);
        cudaGraphDestroy(graph);
    }
    old_.clear();
}

LeadNodes LeadGraph::behind(int step, const std::vector<LeadLaunch>& launches) const {
    const int targets = targets_of(launches), nodes = static_cast<int>(launches.size());
    return {targets_.data() + step * targets, targets, nodes_.data() + step * nodes, nodes};
}

void LeadGraph::capture(const std::vector<LeadLaunch>& launches, cudaStream_t stream,
                        const std::function<void(const LeadNodes&)>& step) {
    const std::size_t each = launches.size() + 1;  // with the decision
    if (steps * launches.size() > most_nodes || steps * targets_of(launches) > static_cast<int>(most_targets))
        throw std::logic_error("a step has more launches than a graph of steps");
    forget();
    check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "Capturing steps");
    for (int s = 0; s < steps; ++s) step(behind(s, launches));
    check(cudaStreamEndCapture(stream, &graph_), "Capturing steps");

    std::size_t count = 0;
    check(cudaGraphGetNodes(graph_, nullptr, &count), "Capturing steps");
    if (count != steps * each) throw std::logic_error("a captured step has not the launches that it should");
    std::vector<cudaGraphNode_t> all(count);
    check(cudaGraphGetNodes(graph_, all.data(), &count), "Capturing steps");  // in the order of their capture
    std::vector<LeadTarget> targets;
    std::vector<cudaGraphDeviceNode_t> switched[steps];  // off by the decision of each
    for (std::size_t i = 0; i < count; ++i) {
        if (i % each == 0) continue;
        const std::size_t of = i / each;
        const LeadLaunch& launch = launches[i % each - 1];
        const cudaGraphDeviceNode_t node = handle_of(all[i]);
        switched[launch.beside ? 1 - of : of].push_back(node);
        if (launch.dt_parameter < 0) continue;
        const std::size_t at = place_of(all[i], launch);
        targets.push_back({node, at + launch.dt, LeadTarget::Value::dt});
        if (launch.gravity_impulse > 0)
            targets.push_back({node, at + launch.gravity_impulse, LeadTarget::Value::gravity_impulse});
    }
    std::vector<cudaGraphDeviceNode_t> nodes;
    for (const std::vector<cudaGraphDeviceNode_t>& of_step : switched)
        nodes.insert(nodes.end(), of_step.begin(), of_step.end());
    node_count_ = static_cast<int>(nodes.size());
    targets_.assign(targets, stream);
    nodes_.assign(nodes, stream);
    check(cudaGraphInstantiate(&run_, graph_, 0), "Making steps ready");
    check(cudaGraphUpload(run_, stream), "Making steps ready");
    check(cudaStreamSynchronize(stream), "Making steps ready");
}

}  // namespace moraine::gpu
