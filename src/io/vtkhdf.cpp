#include "io/vtkhdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numeric>

#include "core/error.hpp"
#include "io/disk_file.hpp"
#include "io/h5.hpp"

namespace moraine {

using vtkhdf::Address;
using vtkhdf::SeriesArray;

/// Where the next output goes: known to rank 0, told to all.
struct ParticleSeries::Plan {
    Address at = 0;
    std::int64_t chunk_rows = 0;
    std::int64_t vertices = 0;  ///< numbers of vertices to write; 0: those of an earlier output suffice
    bool first = true;          ///< there is no file yet: write under a temporary name
    bool failed = false;        ///< rank 0 cannot write there
};

namespace {

Address aligned(Address at) {
    return (at + 4095) / 4096 * 4096;
}

std::int64_t chunks_of(std::int64_t rows, std::int64_t chunk_rows) {
    return (rows + chunk_rows - 1) / chunk_rows;
}

int components_in_file(const Column& column) {
    return column.components == 2 ? 3 : column.components;
}

/// Bytes that an output of this column takes, its padding included.
Address bytes_of(const Column& column, std::int64_t rows, std::int64_t chunk_rows) {
    const int row_bytes = components_in_file(column) * Column::bytes_of(column.type);
    return static_cast<Address>(chunks_of(rows, chunk_rows) * chunk_rows * row_bytes);
}

/// Rows of two numbers to rows of three.
std::vector<std::byte> with_zero(const std::vector<std::byte>& rows, std::size_t number_bytes) {
    const std::size_t count = rows.size() / (2 * number_bytes);
    std::vector<std::byte> wide(count * 3 * number_bytes);
    for (std::size_t r = 0; r < count; ++r)
        std::memcpy(wide.data() + r * 3 * number_bytes, rows.data() + r * 2 * number_bytes, 2 * number_bytes);
    return wide;
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

ParticleSeries::ParticleSeries(const Comm& comm, std::string path) : comm_(comm), path_(std::move(path)) {
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

ParticleSeries::Plan ParticleSeries::plan(std::int64_t rows) const {
    Plan mine;
    std::string trouble;
    if (comm_.is_root()) {
        mine.first = state_.steps.empty();
        // Eight chunks an output: the last is padded by an eighth of the rows at most, and all stay
        // below the format's 4 GiB.
        constexpr std::int64_t few = 1024;
        constexpr std::int64_t many = std::int64_t(1) << 25;
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
    const Plan agreed = comm_.of_root(mine);
    if (agreed.failed) comm_.agree_no_error<MachineError>(trouble);
    return agreed;
}

void ParticleSeries::write_rows(const Plan& plan, const RowOrder& order, std::span<const Column> columns,
                                std::int64_t rows) const {
    std::unique_ptr<DiskFile> file;
    std::string trouble = message_of(
        [&] { file = std::make_unique<DiskFile>(plan.first ? partial_name(path_) : path_, DiskFile::Mode::append); });
    Address at = plan.at;
    for (const std::span<const Column> group : column_groups(columns)) {
        auto slices = order.to_file(group);
        for (std::size_t k = 0; k < group.size(); ++k) {
            const auto number_bytes = static_cast<std::size_t>(Column::bytes_of(group[k].type));
            if (group[k].components == 2) slices[k] = with_zero(slices[k], number_bytes);
            const auto row_bytes = components_in_file(group[k]) * static_cast<std::int64_t>(number_bytes);
            if (trouble.empty())
                trouble = message_of(
                    [&] { file->write(slices[k], static_cast<std::int64_t>(at) + order.slice().start * row_bytes); });
            at += bytes_of(group[k], rows, plan.chunk_rows);
        }
    }
    if (plan.vertices > 0 && trouble.empty())
        trouble = message_of([&] {
            const bool last = comm_.rank() + 1 == comm_.size();
            std::vector<std::int64_t> numbers(static_cast<std::size_t>(order.slice().count + (last ? 1 : 0)));
            std::iota(numbers.begin(), numbers.end(), order.slice().start);
            file->write(std::as_bytes(std::span(numbers)), static_cast<std::int64_t>(at) + order.slice().start * 8);
        });
    if (trouble.empty()) trouble = message_of([&] { file->sync(); });
    comm_.agree_no_error<MachineError>(trouble);
}

void ParticleSeries::record(const Plan& plan, double time, std::int64_t rows, std::span<const Column> columns) {
    vtkhdf::SeriesState next = state_;
    next.chunk_rows = plan.chunk_rows;
    const std::int64_t first_chunk = next.next_chunk();
    next.steps.push_back({time, rows, first_chunk});
    Address at = plan.at;
    for (const Column& column : columns) {
        auto found = std::find_if(next.arrays.begin(), next.arrays.end(),
                                  [&](const SeriesArray& a) { return a.name == column.name; });
        if (found == next.arrays.end())
            found = next.arrays.insert(found, {column.name, column.unit, column.type, components_in_file(column)});
        if (found->type != column.type || found->components != components_in_file(column))
            throw MachineError(fmt::format("cannot continue array {} of {} (its type has changed). Another --output?",
                                           column.name, path_));
        const std::int64_t chunk_bytes = plan.chunk_rows * found->row_bytes();
        for (std::int64_t c = 0; c < chunks_of(rows, plan.chunk_rows); ++c)
            found->chunks.push_back({first_chunk + c, at + static_cast<Address>(c * chunk_bytes)});
        at += bytes_of(column, rows, plan.chunk_rows);
    }
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
                if (array.name == name && (array.type != column.type || array.components != components_in_file(column)))
                    throw InputError(fmt::format(
                        "cannot continue {} (its {} has {} numbers of {} bytes a particle, this run's would have {} "
                        "of {}). The output.precision it began with, or another --output?",
                        path_, name, array.components, Column::bytes_of(array.type), components_in_file(column),
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
    const FileOrder order = file_order(comm_, my_blocks);
    const std::vector<Column> columns = columns_of(my_blocks, position, fields, labels);
    const Plan where = plan(order.rows);
    write_rows(where, RowOrder(comm_, order.of_ranks, order.rows), columns, order.rows);
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (comm_.is_root()) record(where, time, order.rows, columns);
    }));
}

}  // namespace moraine
