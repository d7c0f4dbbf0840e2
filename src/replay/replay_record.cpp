#include "replay/replay_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "balance/cut.hpp"
#include "comm/phases.hpp"
#include "core/data/block.hpp"
#include "core/data/error.hpp"
#include "replay/flow_speed.hpp"

namespace moraine {
namespace {

Layout layout_of(const LoadHeader& h, int refine) {
    Layout layout;
    layout.dimensions = h.dimensions;
    layout.width = h.width;
    for (std::size_t a = 0; a < 3; ++a) {
        layout.blocks[a] = static_cast<int>(a) < h.dimensions ? h.blocks[a] << refine : 1;
        layout.periodic[a] = h.periodic[a] != 0;
    }
    return layout;
}

/// Children of a block of a grid with cells half as large, in Morton order.
template <int Dim>
void append_children(const BlockLoad& parent, std::vector<BlockLoad>& children) {
    const BlockPosition<Dim> at = Morton<Dim>::decode(parent.key);
    for (int c = 0; c < Block<Dim>::corners; ++c) {
        BlockPosition<Dim> child{};
        for (int a = 0; a < Dim; ++a)
            child[static_cast<std::size_t>(a)] = 2 * at[static_cast<std::size_t>(a)] + Block<Dim>::corner(c, a);
        children.push_back({Morton<Dim>::encode(child), parent.particles, 0, parent.owner});
    }
}

double seconds_of(const RankSeconds& s, std::initializer_list<Phase> phases) {
    double sum = 0;
    for (Phase phase : phases) sum += static_cast<double>(s[static_cast<std::size_t>(phase)]);
    return sum;
}

/// What a step is made of.
constexpr std::initializer_list<Phase> computing_phases{Phase::p2g, Phase::nodes, Phase::g2p};
constexpr std::initializer_list<Phase> exchange_phases{Phase::halo, Phase::agree, Phase::migrate};

/// The step of the last whole row of a table; -1 where there is none.
std::int64_t last_row_step(const std::string& path) {
    std::ifstream file(path);
    std::int64_t step = -1;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line) && !file.eof()) std::from_chars(line.data(), line.data() + line.size(), step);
    return step;
}

}  // namespace

ReplayRecord::ReplayRecord(const ReplayOptions& options)
    : options_(options), path_(options.directory + "/block_loads.bin") {
    if (!std::filesystem::is_directory(options.directory))
        throw InputError(fmt::format("{} is not a run (no such directory). Is the path right?", options.directory));
    if (!std::filesystem::exists(path_))
        throw InputError(fmt::format(
            "{} has no block_loads.bin (the run did not record them). Run it again with --set output.block_loads=on?",
            options.directory));
    header_ = BlockLoadReader(path_).header();
    sleepers_ = static_cast<SleepersRecord>(header_.sleepers);
    check_sleepers();
    coarse_ = layout_of(header_, 0);
    layout_ = layout_of(header_, options.refine);
    balance_.partitioner = header_.partitioner.data();
    balance_.weight = header_.weighs_cost ? "cost" : "particles";
    balance_.trigger = static_cast<Trigger>(header_.trigger);
    balance_.interval = header_.interval;
    balance_.threshold = header_.threshold;
    balance_.axis = header_.axis;
    weights_ = {header_.model[0], 0, header_.model[1]};
    read_through();
    check_end();
    for (const std::string& directory : options.calibrate) calibrate(directory);
    model_ = fit_.model(weights_);
    if (header_.weighs_cost) weights_ = {std::llround(1e12 * model_.particle), 0, std::llround(1e12 * model_.block)};
    set_network(model_);
    model_.moves = {header_.moves[0], header_.moves[1]};
    blocks_between_checks_ = cells_per_step(options.directory) * balance_.interval * options.every *
                             static_cast<double>(1 << options.refine) / 4;
}

void ReplayRecord::check_sleepers() const {
    if (!options_.sleep || sleepers_ != SleepersRecord::none) return;
    throw InputError(
        fmt::format("--sleep of {} (its record does not say who would sleep). Run it again with "
                    "--set output.block_loads=sleep?",
                    options_.directory));
}

void ReplayRecord::set_network(TimeModel& model) const {
    const auto given = [](double value, double otherwise) { return value >= 0 ? value : otherwise; };
    model.network = {options_.latency, options_.bandwidth};
    model.within = {given(options_.latency_within, options_.latency),
                    given(options_.bandwidth_within, options_.bandwidth)};
    model.ranks_per_host = options_.ranks_per_host;
}

/// Takes the times of another run of the same machine and method into the model.
void ReplayRecord::calibrate(const std::string& directory) {
    ReplayOptions options;
    options.directory = directory;
    options.latency = options_.latency, options.bandwidth = options_.bandwidth;
    options.latency_within = options_.latency_within, options.bandwidth_within = options_.bandwidth_within;
    options.ranks_per_host = options_.ranks_per_host;
    const ReplayRecord other(options);
    const LoadHeader& h = other.header_;
    if (h.dimensions != header_.dimensions || h.width != header_.width || h.node_bytes != header_.node_bytes ||
        h.rounds != header_.rounds || h.model != header_.model)
        throw InputError(
            fmt::format("--calibrate {} (its dimensions, precision, method or device are others than those "
                        "of {}). Leave it out?",
                        directory, options_.directory));
    fit_.add(other.fit_);
}

bool ReplayRecord::next(BlockLoadReader& reader, LoadFrame& frame) const {
    return reader.position() >= 0 && last_step_ < options_.last_step && reader.next(frame) &&
           frame.step <= options_.last_step;
}

Interval ReplayRecord::interval_of(LoadFrame& frame) const {
    Interval interval;
    interval.step = frame.step;
    interval.blocks.reserve(frame.rows.size());
    for (const LoadRow& row : frame.rows) {
        interval.blocks.push_back({row.key, row.particles, row.particles, row.owner});
        if (weighs_sleepers()) interval.asleep.push_back(row.asleep);
    }
    frame.rows = {};  // of millions of blocks every copy counts
    return interval;
}

/// Of the steps since the frame before half count as they began, half as they ended.
void ReplayRecord::count_sleepers(const LoadFrame& frame) {
    const double half = checks_ == 0 ? 0 : 0.5 * static_cast<double>(frame.step - last_step_);
    std::array<double, 2> now{};
    for (const LoadRow& row : frame.rows) {
        now[0] += row.particles;
        if (weighs_sleepers() && row.asleep != 0) now[1] += row.particles;
    }
    particle_steps_ += half * (sleepers_before_[0] + now[0]);
    asleep_steps_ += half * (sleepers_before_[1] + now[1]);
    sleepers_before_ = now;
}

/// The same with cells halved as often as was asked for.
Interval ReplayRecord::refined(Interval interval) const {
    for (int k = 0; k < options_.refine; ++k) {
        std::vector<BlockLoad> children;
        std::vector<std::uint8_t> asleep;
        for (const std::uint8_t sleeps : interval.asleep)
            asleep.insert(asleep.end(), layout_.dimensions == 2 ? 4 : 8, sleeps);
        interval.asleep = std::move(asleep);
        children.reserve(interval.blocks.size() * (layout_.dimensions == 2 ? 4 : 8));
        for (const BlockLoad& block : interval.blocks)
            layout_.dimensions == 2 ? append_children<2>(block, children) : append_children<3>(block, children);
        interval.blocks = std::move(children);
    }
    return interval;
}

void ReplayRecord::read_through() {
    BlockLoadReader reader(path_);
    LoadFrame frame;
    Interval before;
    std::unique_ptr<Partitioner> partitioner;
    while (next(reader, frame)) {
        count_sleepers(frame);
        Interval now = interval_of(frame);
        if (!partitioner) {
            partitioner = make_partitioner(balance_, coarse_, static_cast<int>(frame.seconds.size()));
            partitioner->start(now.blocks);
        } else {
            measure(frame, before, now, *partitioner);
        }
        count(now);
        if (checks_ % options_.every == 0) feed(now);
        ++checks_;
        last_step_ = frame.step;
        before = std::move(now);
    }
    if (checks_ > 0 && (checks_ - 1) % options_.every != 0) feed(before);  // the last imbalance check is replayed, too
    if (checks_ < 2)
        throw InputError(fmt::format(
            "{} holds {} imbalance check{} (a replay needs two). {}", path_, checks_, checks_ == 1 ? "" : "s",
            options_.last_step < ReplayOptions{}.last_step ? "A larger --last-step?"
                                                           : "Run it for longer, or with a smaller balance.interval?"));
}

/// The interval that ends at this frame: its samples for the model, and what the run itself did.
void ReplayRecord::measure(const LoadFrame& frame, const Interval& before, const Interval& now,
                           const Partitioner& partitioner) {
    const int ranks = static_cast<int>(frame.seconds.size());
    const auto steps = static_cast<double>(now.step - before.step);
    const auto in_range = [&](const BlockLoad& block) { return block.owner >= 0 && block.owner < ranks; };
    if (!std::all_of(before.blocks.begin(), before.blocks.end(), in_range)) return;  // a restart on fewer ranks
    const Carry carry = carry_between(coarse_, keys_of(before.blocks), now.blocks);
    const std::vector<std::int32_t> begin = present_owners(before.blocks);
    const std::vector<std::int32_t> end = carry.owners(begin, now, coarse_, partitioner);
    const auto loads = [&](const Interval& at, std::span<const std::int32_t> owners) {  // as it ran
        return slept() ? at.loads(owners, ranks) : loads_of_ranks(at.blocks, owners, ranks, &BlockLoad::particles);
    };
    const auto first = loads(before, begin), last = loads(now, end);
    std::vector<double> blocks(frame.seconds.size(), 0);
    for (std::int32_t owner : begin) blocks[owner] += 0.5;
    for (std::int32_t owner : end) blocks[owner] += 0.5;
    ModelFit::Interval interval;
    interval.steps = steps;
    interval.lost = frame.lost / steps;
    interval.check = std::numeric_limits<double>::infinity();
    double stepping = 0;
    for (std::size_t r = 0; r < frame.seconds.size(); ++r) {
        const RankSeconds& s = frame.seconds[r];
        const double computing = seconds_of(s, computing_phases), exchange = seconds_of(s, exchange_phases);
        interval.ranks.push_back(
            {static_cast<double>(first[r] + last[r]) / 2, blocks[r], computing / steps, exchange / steps});
        interval.check = std::min(interval.check, seconds_of(s, {Phase::balance}));
        stepping += computing + exchange + seconds_of(s, {Phase::balance});
    }
    TimeModel network;
    set_network(network);
    HaloForecast halo;
    if (ranks > 1)
        halo = HaloSurroundings(coarse_, before.blocks)
                   .halo(begin, partitioner, ranks, header_.node_bytes, network.hosts(ranks));
    interval.sending = network.sending(halo, ranks, static_cast<double>(frame.exchanges) / steps);
    interval.moves = moves_at_end(now, end, ranks);
    fit_.add(std::move(interval));

    const double at_begin = summary_of(first).imbalance(), at_end = summary_of(last).imbalance();
    measured_.ranks = ranks;
    measured_.partitioner = balance_.partitioner;
    measured_.steps += now.step - before.step;
    ++measured_.intervals;
    measured_.imbalance_sum += steps * (at_begin + at_end) / 2;
    measured_.imbalance_max = std::max({measured_.imbalance_max, at_begin, at_end});
    measured_.bytes += static_cast<double>(frame.exchanges) * static_cast<double>(halo.bytes);
    measured_seconds_ += stepping / ranks;
}

/// What the run's planner reckoned for bringing the blocks from those who had come to hold them to those who hold them.
double ReplayRecord::moves_at_end(const Interval& now, const std::vector<std::int32_t>& held, int ranks) const {
    const std::vector<std::int32_t> owners = present_owners(now.blocks);
    const bool known = std::all_of(owners.begin(), owners.end(), [&](int r) { return r >= 0 && r < ranks; });
    return known ? migration_seconds(now.blocks, held, owners, ranks, {header_.moves[0], header_.moves[1]}) : 0;
}

void ReplayRecord::count(const Interval& coarse) {
    const std::int64_t blocks = children_of_a_block() * static_cast<std::int64_t>(coarse.blocks.size());
    blocks_min_ = checks_ == 0 ? blocks : std::min(blocks_min_, blocks);
    blocks_max_ = std::max(blocks_max_, blocks);
}

/// As if it were refined: the children of a block follow each other on the curve.
void ReplayRecord::feed(const Interval& coarse) {
    std::vector<std::int64_t> weights;
    weights.reserve(static_cast<std::size_t>(children_of_a_block()) * coarse.blocks.size());
    const BlockWeight weight(balance_, weights_);
    for (std::size_t b = 0; b < coarse.blocks.size(); ++b)
        weights.insert(weights.end(), static_cast<std::size_t>(children_of_a_block()), weight(coarse.load(b), 0));
    const auto blocks = static_cast<std::int64_t>(weights.size());
    const std::int64_t fed = even_parts(weights, std::max<std::int64_t>(1, blocks), feed_limit);
    if (checks_ == 0) feeds_at_start_ = fed;
    feeds_always_ = checks_ == 0 ? fed : std::min(feeds_always_, fed);
}

void ReplayRecord::check_end() const {
    const std::string table = options_.directory + "/balance.csv";
    const std::int64_t step = std::min(last_row_step(table), options_.last_step);
    if (step <= last_step_ || step - last_step_ < balance_.interval) return;
    throw InputError(
        fmt::format("{} is truncated (it ends at step {}, {} at step {}). Use what is there, --last-step {}?", path_,
                    last_step_, table, step, last_step_));
}

void ReplayRecord::each_check(const std::function<void(Interval& now, const Carry& carry)>& f) const {
    BlockLoadReader reader(path_);
    LoadFrame frame;
    std::vector<Key> before;
    frame.step = -1;  // of the imbalance check before: nothing is read behind the last one
    int number = 0;
    std::int64_t step = 0, exchanges = 0;  // of the one replayed before; since then
    while (frame.step < last_step_ && reader.next(frame)) {
        exchanges += frame.exchanges;
        if (number++ % options_.every != 0 && frame.step != last_step_) continue;
        Interval now = refined(interval_of(frame));
        now.exchanges =
            static_cast<double>(exchanges) / static_cast<double>(std::max<std::int64_t>(1, now.step - step));
        step = now.step, exchanges = 0;
        const Carry carry = before.empty() ? Carry{} : carry_between(layout_, before, now.blocks);
        f(now, carry);
        before = keys_of(now.blocks);
    }
}

}  // namespace moraine
