#include "io/vtkhdf.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/data/error.hpp"
#include "io/disk_file.hpp"
#include "io/h5.hpp"

namespace moraine {

using vtkhdf::Address;
using vtkhdf::OutputPlan;
using vtkhdf::SeriesArray;
using vtkhdf::SeriesOutput;

namespace {

Address aligned(Address at) {
    return (at + 4095) / 4096 * 4096;
}

std::string partial_name(const std::string& path) {
    return path + ".partial";
}

/// The first bytes of a file, which say where all else is; fewer where it has no more.
std::vector<std::byte> head_of(const std::string& path) {
    std::vector<std::byte> head(hdf5::superblock_bytes);
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(file.gcount()));
    return head;
}

}  // namespace

ParticleSeries::ParticleSeries(const Comm& comm, std::string path, const SeriesOptions& options)
    : comm_(comm), path_(std::move(path)), options_(options) {
    comm.agree_no_error<InputError>(message_of([&] {
        if (!comm.is_root() || !std::filesystem::exists(path_)) return;
        try {
            state_ = vtkhdf::read_state(path_);
            head_ = head_of(path_);
        } catch (const H5Failure& failure) {
            throw InputError(fmt::format("cannot continue {} ({}). Another --output?", path_, failure.what()));
        }
    }));
}

std::vector<double> ParticleSeries::times() const {
    std::vector<double> list;
    for (const auto& step : state_.steps) list.push_back(step.time);
    return list;
}

void ParticleSeries::truncate_to(double time) {
    comm_.agree_no_error<MachineError>(message_of([&] {
        vtkhdf::SeriesState next = state_;
        while (!next.steps.empty() && next.steps.back().time > time) next.steps.pop_back();
        if (next.steps.size() == state_.steps.size()) return;
        if (next.steps.empty()) {
            std::filesystem::remove(path_);
            state_ = {};
            return;
        }
        for (SeriesArray& array : next.arrays) {
            std::erase_if(array.chunks, [&](const vtkhdf::Chunk& c) { return c.index >= next.next_chunk(); });
            array.full_nodes.clear();
        }
        commit(std::move(next), state_.end, path_);
    }));
}

OutputPlan ParticleSeries::plan(std::int64_t rows) const {
    OutputPlan mine;
    std::string trouble;
    if (comm_.is_root()) {
        mine.first = state_.steps.empty();
        mine.deflate = options_.deflate;
        // Eight chunks an output: the last is padded by an eighth of the rows at most, and all stay below the format's
        // 4 GiB. Compressed ones are padded by nothing, and small enough for many ranks and for the library's cache.
        constexpr std::int64_t few = 1024;
        const std::int64_t many = std::int64_t(1) << (mine.deflate ? 15 : 25);
        mine.chunk_rows = mine.first ? std::clamp((rows + 7) / 8, few, many) : state_.chunk_rows;
        mine.at = aligned(state_.end);
        mine.vertices = rows + 1 > state_.vertices_count ? rows + 1 : 0;
        trouble = message_of([&] {
            if (mine.first)
                DiskFile(partial_name(path_), DiskFile::Mode::create);
            else
                check_ours();
        });
        mine.failed = !trouble.empty();
    }
    const OutputPlan agreed = comm_.of_root(mine);
    if (agreed.failed) comm_.agree_no_error<MachineError>(trouble);
    return agreed;
}

void ParticleSeries::record(const SeriesOutput& output, double time) {
    vtkhdf::SeriesState next = state_;
    const OutputPlan& plan = output.plan();
    next.chunk_rows = plan.chunk_rows;
    if (plan.deflate && !std::exchange(next.filtered, true))
        for (SeriesArray& array : next.arrays) array.full_nodes.clear();  // they do not say that their chunks are plain
    const std::int64_t first_chunk = next.next_chunk();
    next.steps.push_back({time, output.rows(), first_chunk});
    for (std::size_t c = 0; c < output.columns().size(); ++c) {
        const Column& column = output.columns()[c];
        auto found = std::find_if(next.arrays.begin(), next.arrays.end(),
                                  [&](const SeriesArray& a) { return a.name == column.name; });
        if (found == next.arrays.end())
            found =
                next.arrays.insert(found, {column.name, column.unit, column.type, vtkhdf::components_in_file(column)});
        if (found->type != column.type || found->components != vtkhdf::components_in_file(column))
            throw MachineError(fmt::format("cannot continue array {} of {} (its type has changed). Another --output?",
                                           column.name, path_));
        for (vtkhdf::Chunk chunk : output.chunks()[c]) {
            chunk.index += first_chunk;
            found->chunks.push_back(chunk);
        }
    }
    Address at = output.vertices_at();
    if (plan.vertices > 0) {
        next.vertices = at;
        next.vertices_count = plan.vertices;
        at += static_cast<Address>(8 * plan.vertices);
    }
    commit(std::move(next), at, plan.first ? partial_name(path_) : path_);
    if (plan.first) move_file(partial_name(path_), path_);
}

/// Makes `next` what the file says, its metadata at `from`: the last write is the switch.
void ParticleSeries::commit(vtkhdf::SeriesState next, Address from, const std::string& path) {
    Address root = 0;
    const Address at = (from + 7) / 8 * 8;
    const auto bytes = vtkhdf::metadata(next, at, root);
    next.end = at + bytes.size();
    DiskFile file(path, DiskFile::Mode::append);
    file.write(bytes, static_cast<std::int64_t>(at));
    file.sync();
    const auto head = hdf5::superblock(root, next.end);
    file.write(head, 0);
    file.sync();
    head_.assign(head.begin(), head.end());
    state_ = std::move(next);
}

/// Where locks do not reach (a file system without flock), another run may have begun the file anew: rows at our places
/// would then spoil both.
void ParticleSeries::check_ours() const {
    if (!std::filesystem::exists(path_) || head_of(path_) == head_) return;
    throw MachineError(
        fmt::format("{} is not what this run left there (another wrote into it). Give every run a directory of its "
                    "own, and restart from the last checkpoint?",
                    path_));
}

void ParticleSeries::check_types(const Column& position, std::span<const Column> fields) const {
    comm_.agree_no_error<InputError>(message_of([&] {
        const auto check = [&](const std::string& name, const Column& column) {
            for (const SeriesArray& array : state_.arrays)
                if (array.name == name &&
                    (array.type != column.type || array.components != vtkhdf::components_in_file(column)))
                    throw InputError(fmt::format(
                        "cannot continue {} (its {} has {} numbers of {} bytes a particle, this run's would have {} "
                        "of {}). The output.precision it began with, or another --output?",
                        path_, name, array.components, Column::bytes_of(array.type), vtkhdf::components_in_file(column),
                        Column::bytes_of(column.type)));
        };
        check("Points", position);
        for (const Column& field : fields) check(field.name, field);
    }));
}

std::vector<Column> ParticleSeries::columns_of(std::span<const BlockRow> my_blocks, const Column& position,
                                               std::span<const Column> fields, const SeriesLabels& labels) const {
    const auto per_block = [my_blocks](std::byte* rows, const auto& value_of) {
        auto* at = reinterpret_cast<decltype(value_of(BlockRow{}))*>(rows);
        for (const BlockRow& block : my_blocks) at = std::fill_n(at, block.count, value_of(block));
    };
    std::vector<Column> columns{position};
    columns[0].name = "Points";
    if (labels.rank) columns.push_back({"rank", "", Column::Type::u32});
    if (labels.rank)
        columns.back().make = [this, per_block](std::byte* rows) {
            per_block(rows, [&](const BlockRow&) { return static_cast<std::uint32_t>(comm_.rank()); });
        };
    if (labels.block_key) columns.push_back({"block_key", "", Column::Type::u64});
    if (labels.block_key)
        columns.back().make = [per_block](std::byte* rows) {
            per_block(rows, [](const BlockRow& block) { return block.key; });
        };
    columns.insert(columns.end(), fields.begin(), fields.end());
    return columns;
}

void ParticleSeries::append(double time, std::span<const BlockRow> my_blocks, const Column& position,
                            std::span<const Column> fields, const SeriesLabels& labels) {
    finish();
    const FileOrder order = file_order(comm_, my_blocks);
    const std::vector<Column> columns = columns_of(my_blocks, position, fields, labels);
    const OutputPlan where = plan(order.rows);
    const RowOrder exchange(comm_, order.of_ranks, order.rows, where.deflate ? where.chunk_rows : 1);
    output_ = std::make_unique<SeriesOutput>(where, where.first ? partial_name(path_) : path_, columns, order.rows,
                                             exchange.slice());
    time_ = time;
    const int threads = options_.asynchronous ? 1 : omp_get_max_threads();
    for (const std::span<const Column> group : column_groups(columns)) {
        for (auto& slice : exchange.to_file(group)) output_->take(std::move(slice));
        if (options_.asynchronous) continue;
        output_->deflate(threads);
        if (!where.deflate) output_->write();
    }
    begin(Stage::compress, [this, threads] { output_->deflate(threads); });
    if (!options_.asynchronous) finish();
}

void ParticleSeries::begin(Stage stage, std::function<void()> work) {
    stage_ = stage;
    if (options_.asynchronous)
        work_ = std::async(std::launch::async, std::move(work));
    else
        work();
}

bool ParticleSeries::busy() const {
    return work_.valid() && work_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

void ParticleSeries::advance() {
    if (work_.valid()) work_.get();
    if (stage_ == Stage::compress) {
        output_->place(comm_);
        begin(Stage::write, [this] {
            output_->write();
            output_->finish();
        });
    } else if (stage_ == Stage::write) {
        trouble_ = output_->trouble();
        end_if_trouble();
        begin(Stage::commit, [this] {
            if (comm_.is_root()) trouble_ = message_of([&] { record(*output_, time_); });
        });
    } else if (stage_ == Stage::commit) {
        end_if_trouble();
        output_.reset();
        stage_ = Stage::none;
    }
}

/// Throws on all ranks what any of them met; the output is given up.
void ParticleSeries::end_if_trouble() {
    try {
        comm_.agree_no_error<MachineError>(trouble_);
    } catch (const MachineError&) {
        output_.reset();
        stage_ = Stage::none;
        throw;
    }
}

void ParticleSeries::finish() {
    while (under_way()) advance();
}

}  // namespace moraine
