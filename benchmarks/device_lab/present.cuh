#pragma once
// The step as the program does it: its own kernels, launched as gpu/engine_step.cpp does on one device.

#include <algorithm>
#include <utility>

#include "device_lab/share.cuh"

namespace moraine::gpu::lab {

template <class Real, class Law>
class Present {
  public:
    static constexpr const char* phases[] = {"p2g", "nodes", "g2p", "collect", "lists", "refresh"};
    static constexpr int phase_count = 6, refresh_interval = 12;

    Present(const Column<Real>& column, const Motion& motion, const Law& law)
        : motion_(motion),
          law_(law),
          n_(std::uint32_t(column.particle.size())),
          own_(column.box.own),
          memory_(column.box, column.particle.size(), column.particle.size()),
          p2g_(P2gLaunch<LabCase<Real>>::ready()),
          gather_{g2p_fused<Real, 3, Quadratic, Law, false, false, false, FluidGrid::none,
                            fused_blocks<Real, Law, false, false, false, FluidGrid::none>()>,
                  sizeof(typename FusedGather<Real, 3, Quadratic, Law, false, false, false, FluidGrid::none>::Shared),
                  "Launching the gather"} {
        const auto all = std::size_t(n_), own = std::size_t(own_);
        std::vector<Row<Real>> rows(all);
        for (int r = 0; r < core_rows<3>; ++r) {
            for (std::size_t k = 0; k < all; ++k) rows[k] = first_row(column.particle[k], motion, r);
            memory_.row[r].assign(rows);
        }
        first_.assign(column.first), cell_first_.assign(column.cell_first), next_first_.resize(own + 1);
        slot_.resize(all), next_slot_.resize(all), out_slot_.resize(all), out_cell_.resize(all), moves_.resize(all);
        count_up(n_, slot_.data(), nullptr);
        changed_.resize(all / 32 + own + 1), zero(changed_);
        boundary_.resize(own), zero(boundary_), guard_layer_.resize(own), zero(guard_layer_);
        out_count_.resize(own), out_bound_.resize(own * outgoing_bounds<3>);
        boundary_list_.resize(own), interior_list_.resize(own), counts_.resize(5), zero(counts_);
        tally_.resize(std::size_t(binning_chunks(own_)));
        spare_.resize(all), spare_id_.resize(all), body_.resize(all + 1), spare_body_.resize(all + 1), zero(body_);
        number_blocks(binning(), nullptr);
        check(cudaDeviceSynchronize(), "Numbering");
        occupied_ = int(counts_.host()[1]);
    }

    View<Real, 3> view() const {
        View<Real, 3> v = memory_.view(motion_);
        v.list = {first_.data(), cell_first_.data(), slot_.data()};
        v.moves = moves_.data(), v.changed = changed_.data();
        return v;
    }
    void p2g() const { p2g_(view(), chosen(), p2g_grid<3>(occupied_), Real(1), stream_); }
    void refresh_never() { refreshes_ = false; }
    cudaStream_t stream() const { return stream_; }

    /// mark(k) after phase k.
    template <class Mark>
    void step(const Mark& mark) {
        const View<Real, 3> v = view();
        p2g();
        mark(0);
        run_nodes<Real, 3, false, false, false>(node_work(v, motion_), 3, stream_);
        mark(1);
        gather_(Launch{occupied_, stream_}, v, chosen(), gather_args<Real>(motion_), law_, Real(1 / motion_.density));
        mark(2);
        collect_outgoing(binning(), Part::all, occupied_, stream_);
        mark(3);
        make_lists(binning(), stream_);
        first_.swap(next_first_), slot_.swap(next_slot_);
        mark(4);
        if (refreshes_ && ++steps_ % refresh_interval == 0) refresh();
        mark(5);
    }

    const Memory<Real>& memory() const { return memory_; }
    int occupied() const { return occupied_; }

  private:
    Chosen chosen() const { return {interior_list_.data(), counts_.data() + 1}; }

    Binning<3> binning() const {
        Binning<3> f{};
        const View<Real, 3> v = view();
        f.table = v.table, f.list = v.list, f.moves = v.moves, f.changed = v.changed;
        f.boundary = boundary_.data(), f.guard_layer = guard_layer_.data();
        f.outgoing = {out_slot_.data(), out_cell_.data(), out_count_.data(), out_bound_.data(), nullptr};
        f.occupied = {memory_.tile_of.data(), boundary_list_.data(), interior_list_.data(), counts_.data(),
                      counts_.data() + 2,     std::uint32_t(own_),   counts_.data() + 4};
        f.cell_first = cell_first_.data(), f.next_first = next_first_.data(), f.next_slot = next_slot_.data();
        f.tally = tally_.data();
        return f;
    }

    template <class T>
    void permute_column(Array<T>& column, Array<T>& spare) {
        permute(n_, slot_.data(), column.data(), spare.data(), sizeof(T), stream_);
        column.swap(spare);
    }
    void refresh() {
        for (auto& r : memory_.row) permute_column(r, spare_);
        permute_column(memory_.id, spare_id_);
        permute_column(body_, spare_body_);
        count_up(n_, slot_.data(), stream_);
    }

    LabStream stream_;
    bool refreshes_ = true;
    Motion motion_;
    Law law_;
    std::uint32_t n_;
    int own_, occupied_ = 0, steps_ = 0;
    Memory<Real> memory_;
    Array<std::uint32_t> first_, next_first_, cell_first_, slot_, next_slot_, out_slot_, changed_;
    Array<std::uint8_t> out_cell_, boundary_;
    Array<std::uint16_t> moves_, body_, spare_body_;
    Array<std::uint64_t> guard_layer_, spare_id_;
    Array<std::uint32_t> out_count_, out_bound_, counts_;
    Array<std::int32_t> boundary_list_, interior_list_;
    Array<Tally> tally_;
    Array<Row<Real>> spare_;
    P2g<Real, 3> p2g_;
    TeamKernel<3, View<Real, 3>, Chosen, GatherArgs<Real, 3>, Law, Real> gather_;
};

}  // namespace moraine::gpu::lab
