#include <algorithm>
#include <cstdio>
#include <memory>

#include "core/data/error.hpp"
#include "io/checkpoint.hpp"
#include "io/checkpoint_format.hpp"
#include "io/disk_file.hpp"
#include "io/hdf5_image.hpp"

namespace moraine {

using hdf5::Address;

namespace {

struct PutValue {
    hdf5::Region& region;

    Address operator()(std::int64_t v) const { return region.put_values({}, {}, &v); }
    Address operator()(double v) const { return region.put_values({hdf5::ElementType::Kind::real, 8}, {}, &v); }
    Address operator()(const std::string& v) const {
        const auto bytes = static_cast<int>(std::max<std::size_t>(1, v.size()));  // an empty text is one NUL
        return region.put_values({hdf5::ElementType::Kind::text, bytes}, {}, v.c_str());
    }
    template <class T>
    Address operator()(const std::vector<T>& v) const {
        return region.put_list(v, {static_cast<std::int64_t>(v.size())});
    }
};

/// Where the rows of each column begin, and the end of the last: right behind the superblock.
std::vector<Address> places_of(std::span<const Column> columns, std::int64_t rows) {
    std::vector<Address> places{4096};
    for (const Column& column : columns)
        places.push_back((places.back() + static_cast<Address>(rows * column.row_bytes()) + 7) / 8 * 8);
    return places;
}

/// All but the rows, into an empty file.
void lay_out(const std::string& path, const CheckpointHeader& header, const FileOrder& order,
             std::span<const Column> columns, const std::vector<Address>& places) {
    hdf5::Region region(places.back());
    hdf5::Links values;
    for (const auto& [key, value] : header) values.push_back({key, std::visit(PutValue{region}, value)});
    std::vector<Key> keys;
    std::vector<std::int64_t> counts;
    for (const BlockRow& block : order.blocks) {
        keys.push_back(block.key);
        counts.push_back(block.count);
    }
    const auto blocks = static_cast<std::int64_t>(keys.size());
    hdf5::Links particles;
    std::vector<checkpoint::Region> rows;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const Column& column = columns[c];
        const auto set = hdf5::dataset(hdf5::ElementType::of(column.type), {order.rows, column.components},
                                       {places[c], 0}, {hdf5::text_attribute("unit", column.unit)});
        particles.push_back({column.name, region.put(set)});
        rows.push_back({static_cast<std::int64_t>(places[c]), order.rows * column.row_bytes()});
    }
    const hdf5::Links top{
        {"header", region.put(hdf5::group(values, {}))},
        {"blocks", region.put(hdf5::group(
                       {{"key", region.put_list(keys, {blocks})}, {"count", region.put_list(counts, {blocks})}}, {}))},
        {"particles", region.put(hdf5::group(particles, {}))}};
    const std::int64_t version[] = {checkpoint::format_version};
    const Address root = region.put(hdf5::group(top, {hdf5::integer_attribute("format_version", version, true)}));
    DiskFile file(path, DiskFile::Mode::create);
    file.write(region.get(), static_cast<std::int64_t>(places.back()));
    file.write(hdf5::superblock(root, region.end()), 0);
    checkpoint::seal(path, rows);
}

}  // namespace

void write_checkpoint(const Comm& comm, const std::string& path, const CheckpointHeader& header,
                      std::span<const BlockRow> my_blocks, std::span<const Column> columns) {
    const std::string partial = path + ".partial";
    const FileOrder order = file_order(comm, my_blocks);
    const RowOrder exchange(comm, order.of_ranks, order.rows);
    try {
        const std::vector<Address> places = places_of(columns, order.rows);
        comm.agree_no_error<MachineError>(message_of([&] {
            if (comm.is_root()) lay_out(partial, header, order, columns, places);
        }));
        std::unique_ptr<DiskFile> file;
        std::string trouble = message_of([&] { file = std::make_unique<DiskFile>(partial, DiskFile::Mode::append); });
        for (const std::span<const Column> group : column_groups(columns)) {
            const auto slices = exchange.to_file(group);
            for (std::size_t k = 0; k < group.size() && trouble.empty(); ++k)
                trouble = message_of([&] {
                    const auto c = static_cast<std::size_t>(&group[k] - columns.data());
                    file->write(slices[k],
                                static_cast<std::int64_t>(places[c]) + exchange.slice().start * columns[c].row_bytes());
                });
        }
        if (trouble.empty()) trouble = message_of([&] { file->sync(); });
        comm.agree_no_error<MachineError>(trouble);
        comm.agree_no_error<MachineError>(message_of([&] {
            if (comm.is_root()) move_file(partial, path);
        }));
    } catch (const MachineError&) {
        if (comm.is_root()) std::remove(partial.c_str());
        throw;
    }
}

}  // namespace moraine
