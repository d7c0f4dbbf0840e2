#pragma once
// Tractions on the device (core/particles/traction.hpp): behind P2G, a thread block per block finds what each of its
// particles is given, once a step, and adds it to the block's tile. A thread has a node and takes the cells around it,
// and their particles in list order, so a sum has one order. Blocks without a particle under a traction are passed by.
// Not in P2G itself: its records and registers are those of scenes without tractions.

#include <cuda_runtime.h>

#include <span>

#include "core/transfer/kernel_key.hpp"
#include "core/transfer/totals.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/kernels/g2p/gather_args.hpp"
#include "gpu/kernels/loads/load_work.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class DeviceLoads {
  public:
    /// Compiles the kernel, or finds it. Throws MachineError.
    explicit DeviceLoads(const KernelKey& key);
    DeviceLoads(const DeviceLoads&) = delete;
    DeviceLoads& operator=(const DeviceLoads&) = delete;
    ~DeviceLoads() { cudaFreeHost(here_); }

    /// Of a run, or of a stage that begins.
    void take(std::span<const Traction<Real, Dim>> tractions);
    /// For an epoch of so many own blocks. Asynchronous.
    void open(std::size_t own, cudaStream_t stream) { loaded_.resize(own, stream); }
    /// A step begins. factors: by traction; most: capacity of the lists. Asynchronous.
    void begin_step(std::span<const double> factors, std::size_t most, cudaStream_t stream);
    /// Adds to tiles that P2G has written. blocks: about how many are chosen. Asynchronous.
    void add(const View<Real, Dim>& view, const Chosen& chosen, int blocks, cudaStream_t stream) const;
    /// The next sums are of the same step.
    void has_set() { work_.sets = false; }
    LoadArgs<Real, Dim> args() const { return {loads_.data(), loaded_.data(), sums_.data()}; }
    /// Queues the copy of what they did. Asynchronous.
    void fetch(cudaStream_t stream);
    /// Adds what was fetched and not added yet; the copy must be done.
    void add_to(Budget<Dim>& budget);

  private:
    Kernel kernel_;
    LoadWork<Real, Dim> work_{};
    Array<ParticleLoad<Real, Dim>> loads_;
    PoolArray<std::uint8_t> loaded_;
    Array<LoadSums<Dim>> sums_;
    LoadSums<Dim>* here_ = nullptr;  ///< pinned
    bool fetched_ = false;           ///< and not added
};

}  // namespace moraine::gpu
