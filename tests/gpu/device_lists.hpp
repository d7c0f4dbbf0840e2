#pragma once
// The lists of a share on the device with all that binning needs around them, for tests: uploaded once, then binned
// step by step from moves that the host makes up. What binning writes is poisoned before each step, so that what it
// reads it has written; outgoing particles of ghost blocks come as the host has them and are sorted here by exit.

#include <vector>

#include "core/grid/binning.hpp"
#include "gpu/kernels/binning/binning.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::test {

/// Outgoing particles of ghost blocks, sorted by exit as the device wants them.
struct GhostOutgoing {
    std::vector<std::uint32_t> slot, start, count, bound;
    std::vector<std::uint8_t> cell;

    /// From the host's form: in ghost order, ghosts + 1 bounds.
    template <int Dim>
    static GhostOutgoing of(const std::vector<OutgoingParticle>& outgoing, const std::vector<std::uint32_t>& first) {
        GhostOutgoing g;
        for (std::size_t i = 0; i + 1 < first.size(); ++i) {
            g.start.push_back(static_cast<std::uint32_t>(g.slot.size()));
            for (int exit = 0; exit <= Block<Dim>::offsets; ++exit) {
                g.bound.push_back(static_cast<std::uint32_t>(g.slot.size()) - g.start.back());
                for (std::uint32_t k = first[i]; k < first[i + 1]; ++k)
                    if (move_code(outgoing[k].move) == exit) {
                        g.slot.push_back(outgoing[k].slot);
                        g.cell.push_back(static_cast<std::uint8_t>(move_cell(outgoing[k].move)));
                    }
            }
            g.bound.push_back(static_cast<std::uint32_t>(g.slot.size()) - g.start.back());
            g.count.push_back(g.bound.back());
        }
        return g;
    }
};

template <int Dim>
class DeviceLists {
    static constexpr std::size_t bounds = gpu::outgoing_bounds<Dim>;

  public:
    gpu::Binning<Dim> binning{};

    /// capacity: the most particles, with outgoing particles of ghosts, that there ever will be.
    DeviceLists(const BlockTable<Dim>& table, const ListView<Dim>& list, const std::vector<std::uint8_t>& boundary,
                const std::vector<std::uint64_t>& guard_layer, std::size_t capacity)
        : own_(static_cast<std::size_t>(table.own)), ghosts_(static_cast<std::size_t>(table.ghosts)) {
        binning.table = table;
        binning.table.neighbour = upload(neighbour_, table.neighbour, own_ * Block<Dim>::offsets);
        binning.boundary = upload(on_boundary_, boundary.data(), own_);
        binning.guard_layer = upload(guard_layer_, guard_layer.data(), own_);
        binning.first_tile = table.ghosts;
        first_.assign(list.first, own_ + 1), next_first_.resize(own_ + 1);
        slot_.reserve(capacity), next_slot_.reserve(capacity), moves_.reserve(capacity);
        slot_.assign(list.slot, list.first[own_]), next_slot_.resize(capacity);
        binning.cell_first = upload(cell_first_, list.cell_first, own_ * (Block<Dim>::cells + 1));
        changed_.reserve(capacity / 32 + own_ + 1);
        outgoing_slot_.resize(capacity), outgoing_cell_.resize(capacity),
            outgoing_bound_.resize((own_ + ghosts_) * bounds);
        outgoing_count_.resize(own_ + ghosts_);
        tile_of_.resize(own_), boundary_.resize(own_), interior_.resize(own_), occupied_.resize(5);
        tally_.resize(static_cast<std::size_t>(gpu::binning_chunks(table.own)));
        poison_results();
        point();
        gpu::number_blocks(binning, nullptr);
    }

    void set_moves(const std::vector<std::uint16_t>& moves, const std::vector<std::uint32_t>& changed) {
        moves_.assign(moves), changed_.assign(changed);
        poison_results();
        point();
    }

    /// Puts them behind the own outgoing particles.
    void set_ghosts(GhostOutgoing ghosts) {
        if (ghosts_ == 0) return;
        const std::size_t behind = slot_.size();
        for (std::uint32_t& s : ghosts.start) s += static_cast<std::uint32_t>(behind);
        ghost_start_.assign(ghosts.start);
        put(outgoing_slot_.data() + behind, ghosts.slot), put(outgoing_cell_.data() + behind, ghosts.cell);
        put(outgoing_bound_.data() + own_ * bounds, ghosts.bound), put(outgoing_count_.data() + own_, ghosts.count);
        point();
    }

    void launch() const {
        gpu::collect_outgoing(binning, gpu::Part::boundary, binning.table.own, nullptr);
        gpu::collect_outgoing(binning, gpu::Part::interior, binning.table.own, nullptr);
        gpu::make_lists(binning, nullptr);
    }

    /// The next lists become the lists.
    void advance() {
        gpu::check(cudaDeviceSynchronize(), "Binning");
        first_.swap(next_first_);
        const std::size_t capacity = next_slot_.size();
        slot_.swap(next_slot_);
        slot_.resize(first().back()), next_slot_.resize(capacity);
        point();
    }

    std::vector<std::uint32_t> first() const { return first_.host(); }
    std::vector<std::uint32_t> slot() const { return slot_.host(); }
    std::vector<std::uint32_t> cell_first() const { return cell_first_.host(); }
    void set_cell_first(const std::uint32_t* from) { cell_first_.assign(from, cell_first_.size()); }
    std::vector<std::int32_t> tile_of() const { return tile_of_.host(); }
    std::uint32_t tiles = ~0u;  ///< that there is capacity for; from the next step on
    std::vector<std::uint32_t> counts() const { return occupied_.host(); }
    bool is_in_guard_layer() const { return occupied_.host()[4] != 0; }
    std::vector<std::int32_t> boundary() const { return head(boundary_, occupied_.host()[0]); }
    std::vector<std::int32_t> interior() const { return head(interior_, occupied_.host()[1]); }

  private:
    template <class T>
    static T* upload(gpu::Array<T>& to, const T* from, std::size_t n) {
        to.assign(from, n);
        return to.data();
    }
    template <class T>
    static void put(T* to, const std::vector<T>& from) {
        gpu::check(cudaMemcpy(to, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice), "Copying");
    }
    template <class T>
    static void poison(const gpu::Array<T>& array) {
        gpu::check(cudaMemset(array.data(), 0xff, array.size() * sizeof(T)), "Poisoning");
    }
    void poison_results() {
        poison(next_first_), poison(next_slot_), poison(tally_);
        poison(outgoing_slot_), poison(outgoing_cell_), poison(outgoing_count_), poison(outgoing_bound_);
    }
    /// The first n: what lies behind them nobody has written.
    static std::vector<std::int32_t> head(const gpu::Array<std::int32_t>& array, std::size_t n) {
        std::vector<std::int32_t> to(n);
        if (n > 0)
            gpu::check(cudaMemcpy(to.data(), array.data(), n * sizeof(to[0]), cudaMemcpyDeviceToHost), "Copying");
        return to;
    }
    void point() {
        binning.list = {first_.data(), cell_first_.data(), slot_.data()};
        binning.moves = moves_.data(), binning.changed = changed_.data();
        binning.outgoing = {outgoing_slot_.data(), outgoing_cell_.data(), outgoing_count_.data(),
                            outgoing_bound_.data(), ghost_start_.data()};
        binning.occupied = {tile_of_.data(),     boundary_.data(),     interior_.data(),
                            occupied_.data(),    occupied_.data() + 2, tiles,
                            occupied_.data() + 4};
        binning.next_first = next_first_.data(), binning.next_slot = next_slot_.data();
        binning.tally = tally_.data();
    }

    std::size_t own_, ghosts_;
    gpu::Array<std::int32_t> neighbour_, tile_of_, boundary_, interior_;
    gpu::Array<std::uint8_t> on_boundary_, outgoing_cell_;
    gpu::Array<std::uint32_t> first_, next_first_, slot_, next_slot_, cell_first_, changed_;
    gpu::Array<std::uint32_t> outgoing_slot_, outgoing_count_, outgoing_bound_, ghost_start_, occupied_;
    gpu::Array<std::uint16_t> moves_;
    gpu::Array<std::uint64_t> guard_layer_;
    gpu::Array<gpu::Tally> tally_;
};

}  // namespace moraine::test
