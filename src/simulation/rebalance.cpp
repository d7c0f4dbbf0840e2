#include "simulation/rebalance.hpp"

#include <algorithm>
#include <utility>

#include "blocks/key_order.hpp"

namespace moraine {

std::vector<BlockLoad> merged(const std::vector<BlockLoad>& rows) {
    std::vector<BlockLoad> loads;
    loads.reserve(rows.size());
    for (const BlockLoad& row : rows) {
        if (!loads.empty() && loads.back().key == row.key) {
            loads.back().particles += row.particles;
            loads.back().weight += row.weight;
        } else {
            loads.push_back(row);
        }
    }
    return loads;
}

template <int Dim>
std::int64_t Rebalance<Dim>::steps_ahead() const {
    if (!async_ || partitioner_.is_collective()) return 0;
    return std::min<std::int64_t>(most_steps_ahead, spec_.interval / 2);
}

template <int Dim>
void Rebalance<Dim>::want(std::int64_t step) {
    const bool alone = comm_.size() == 1 && spec_.trigger != Trigger::every;
    if (!wanted_ && trigger_.is_due(step + steps_ahead()) && !alone) wanted_ = step;
}

template <int Dim>
bool Rebalance<Dim>::is_to_begin(std::int64_t step, const EpochLifetime& epoch, double moved) const {
    if (!wanted_ || is_under_way()) return false;
    if (steps_ahead() == 0 || spec_.trigger == Trigger::every) return true;
    if (step >= *wanted_ + spec_.interval) return true;
    return !epoch.ends_within(static_cast<double>(2 * steps_ahead()) * moved);
}

template <int Dim>
void Rebalance<Dim>::skip(ImbalanceCheck found) {
    wanted_.reset();
    end(std::move(found));
}

template <int Dim>
void Rebalance<Dim>::begin(std::int64_t step, std::vector<BlockLoad> mine, ImbalanceCheckInput input) {
    const std::int64_t wanted = std::exchange(wanted_, {}).value_or(step);
    due_ = step + steps_ahead();
    latest_ = due_;
    if (steps_ahead() > 0 && spec_.trigger != Trigger::every)
        latest_ = std::max(due_, wanted + spec_.interval - 1);  // one more, and the next is wanted
    input_ = std::move(input);
    loads_.start(std::move(mine));
    state_ = State::gathering;
}

template <int Dim>
void Rebalance<Dim>::advance(std::int64_t step, bool making, bool now) {
    const bool all_have_planned = state_ == State::planning && !making;
    const bool ends = (step >= due_ && all_have_planned) || step >= latest_ || now;
    if (state_ == State::gathering)
        if (auto all = ends ? loads_.finish() : loads_.advance()) {
            plan(std::move(all->rows), std::move(all->counts));
            state_ = State::planning;
        }
    if (ends) state_ = State::due;
}

/// On a thread of its own where that is asynchronous, else when the tables are taken.
template <int Dim>
void Rebalance<Dim>::plan(std::vector<BlockLoad> blocks, std::vector<std::int64_t> counts) {
    const std::size_t count = blocks.size();
    const auto owners = [this, blocks = std::move(blocks), counts = std::move(counts)] {
        const std::vector<BlockLoad> loads = merged(in_key_order(blocks, counts));
        planned_ = check_imbalance(loads, input_, comm_.size(), partitioner_, trigger_);
        std::vector<OccupiedBlock> occupied;
        for (std::size_t b = 0; b < planned_.owners.size(); ++b) occupied.push_back({loads[b].key, planned_.owners[b]});
        return occupied;
    };
    next_epoch_.start_repartition(count, owners, steps_ahead() > 0);
}

template <int Dim>
std::optional<EpochTables<Dim>> Rebalance<Dim>::take() {
    std::optional<EpochTables<Dim>> tables = next_epoch_.take();
    state_ = State::idle;
    end(planned_.found);
    return tables;
}

template <int Dim>
void Rebalance<Dim>::end(ImbalanceCheck found) {
    if (found.repartitioned || !last_.repartitioned) last_ = std::move(found);
}

template class Rebalance<2>;
template class Rebalance<3>;

}  // namespace moraine
