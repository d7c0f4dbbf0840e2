// The engine's gather: grid to particles, with the stress update.

#include <algorithm>

#include "gpu/engine.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
FluidGatherArgs<Real, Dim> DeviceEngine<Real, Dim>::gather_args(const Round& round, const StepScales<Dim>& step) const {
    FluidGatherArgs<Real, Dim> args{};
    args.ends = method_.ends;
    args.gather = round.gather;
    args.tpic = method_.tpic;
    args.flip = method_.flip;
    args.dt = static_cast<Real>(step.dt);
    std::copy(step.gravity_impulse.begin(), step.gravity_impulse.end(), args.gravity_impulse);
    args.quantum = step.quantum;
    args.averages = method_.averaged() != nullptr;
    args.averaged = kernels_.stress.size() > 1 ? bodies_.averaged.data() : nullptr;
    if (added_.loads) args.loads = added_.loads->args();
    if (limits(round)) args.light = light_.args(method_.limits);
    args.fluid = fluid_.args(method_, scene_.materials.size() > 1, contact_.surfaces);
    if (method_.grid_bulk()) {
        const PressureView<Real, Dim> pressure = fluid_.pressure.view();
        args.cell = pressure.cell, args.bulk = pressure.bulk;
    }
    args.gradient = store_.gradient.data();
    args.gradient_stride = static_cast<std::uint64_t>(store_.rows.capacity());
    return args;
}

/// One part's particles: part 0 is the boundary, 1 the interior.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::gather_part(int part, const Round& round, const FluidGatherArgs<Real, Dim>& args,
                                          const Launch& launch) {
    const Chosen chosen = awake_of(part);
    const bool limiting = limits(round) && !epoch_.tables.own.empty();
    LimitedBlocks found{};
    if (materials_) materials_->sort(part, view(), chosen, limiting, launch);
    if (limiting) {
        found = light_.found(part, epoch_.own());
        kernels_.find_limited(view(), chosen, args, found, launch);
    }
    const Chosen of_limited{found.limited, found.count};
    const Chosen* limited = limiting ? &of_limited : nullptr;
    if (!materials_) return gather_blocks(chosen, limited, round, args, {launch, launch});
    const auto rest = materials_->gather(part, view(), args, limited, launch);
    gather_blocks(rest.chosen, limited, round, args, rest.lanes);
    materials_->finish(part, launch.stream);
}

/// limited: those of the chosen blocks with light nodes; null: there are none.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::gather_blocks(const Chosen& chosen, const Chosen* limited, const Round& round,
                                            const FluidGatherArgs<Real, Dim>& args, const Lanes& lanes) {
    const View<Real, Dim> v = view();
    kernels_.gather->run(v, chosen, args, lanes[0]);
    if (limited) kernels_.gather->run_limited(v, *limited, args, lanes[1]);
    if (!(round.gather & gather_gradient)) return;
    if (materials_) materials_->meet(lanes);
    StressArgs<Real, Dim> stress{args.dt,
                                 args.quantum,
                                 args.gradient,
                                 args.gradient_stride,
                                 kernels_.stress.size() > 1 ? bodies_.material_of.data() : nullptr,
                                 0};
    for (; stress.mine < static_cast<int>(kernels_.stress.size()); ++stress.mine)
        kernels_.stress[static_cast<std::size_t>(stress.mine)].run(v, chosen, stress, lanes[0]);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::gather(const Round& round, const StepScales<Dim>& step) {
    reports_.watch.begin(2, stream_);
    if (materials_ && materials_->choose_grids()) ++epoch_.layout;
    const FluidGatherArgs<Real, Dim> args = gather_args(round, step);
    if (sleepers_) hold_sleepers(step);
    if (exchange_) {  // the boundary goes first: its outgoing particles travel during the gather of the interior
        exchange_->solved.record(stream_);
        exchange_->stream.wait_for(exchange_->solved);
        gather_part(0, round, args, {boundary_blocks_, exchange_->stream});
        exchange_->boundary_moved.record(exchange_->stream);
    }
    gather_part(1, round, args, {interior_blocks(), stream_});
    if (exchange_) stream_.wait_for(exchange_->boundary_moved);
    if (added_.loads) added_.loads->has_set();
    if (added_.loads && (round.gather & gather_gradient)) added_.loads->fetch(stream_);
    reports_.watch.end(2, stream_);
    reports_.timed = false;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
