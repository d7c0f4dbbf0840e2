#include <algorithm>

#include "io/vtkhdf_state.hpp"

namespace moraine::vtkhdf {

using namespace hdf5;

namespace {

/// The tree of an array's chunks, bottom up. Full leaves of earlier commits are used again.
Address put_tree(Region& region, SeriesArray& array, const SeriesState& state) {
    if (array.chunks.empty()) return nowhere;
    const ChunkShape shape{state.chunk_rows, array.components, array.row_bytes(), state.filtered};
    const std::int64_t end = array.chunks.back().index + 1;
    std::vector<Chunk> level = array.full_nodes;
    for (std::size_t i = level.size() * node_entries; i < array.chunks.size(); i += node_entries) {
        const std::size_t count = std::min(node_entries, array.chunks.size() - i);
        const auto children = std::span(array.chunks).subspan(i, count);
        const std::int64_t stop = i + count < array.chunks.size() ? array.chunks[i + count].index : end;
        level.push_back({children[0].index, region.put(chunk_node(shape, 0, children, stop))});
        if (count == node_entries) array.full_nodes.push_back(level.back());
    }
    for (int height = 1; level.size() > 1; ++height) {
        std::vector<Chunk> above;
        for (std::size_t i = 0; i < level.size(); i += node_entries) {
            const std::size_t count = std::min(node_entries, level.size() - i);
            const std::int64_t stop = i + count < level.size() ? level[i + count].index : end;
            const auto children = std::span(level).subspan(i, count);
            above.push_back({level[i].index, region.put(chunk_node(shape, height, children, stop))});
        }
        level = above;
    }
    return level[0].at;
}

Address put_array(Region& region, SeriesArray& array, const SeriesState& state) {
    std::vector<std::int64_t> extent{state.next_chunk() * state.chunk_rows};
    if (array.components > 1) extent.push_back(array.components);
    const Address tree = put_tree(region, array, state);
    std::vector<Attribute> attributes;
    if (!array.unit.empty()) attributes.push_back(text_attribute("unit", array.unit));
    return region.put(
        dataset(ElementType::of(array.type), extent, {tree, state.chunk_rows, state.filtered}, attributes));
}

/// Sizes of the parts, and the part of each step: steps of one size share theirs, as they share their
/// vertices. (VTK 9.3 begins to read the vertices at the number of the part; later versions do not.)
struct Parts {
    std::vector<std::int64_t> rows;
    std::vector<std::int64_t> of_step;

    explicit Parts(const SeriesState& state) {
        for (const SeriesStep& step : state.steps) {
            if (rows.empty() || rows.back() != step.rows) rows.push_back(step.rows);
            of_step.push_back(static_cast<std::int64_t>(rows.size()) - 1);
        }
    }
};

Address put_steps(Region& region, const SeriesState& state, const Parts& parts) {
    const auto n = static_cast<std::int64_t>(state.steps.size());
    std::vector<double> times;
    std::vector<std::int64_t> first_rows;
    for (const SeriesStep& step : state.steps) {
        first_rows.push_back(step.first_chunk * state.chunk_rows);
        times.push_back(step.time);
    }
    const auto arrays = static_cast<int>(state.arrays.size());
    const Address rows = region.put_list(first_rows, {n}, arrays);
    // The same vertices serve every step: their offsets stay zero, one per kind of cell.
    const Address cells = region.put_list(std::vector<std::int64_t>(state.steps.size() * 4), {n, 4}, 2);
    Links data_offsets;
    for (std::size_t a = 1; a < state.arrays.size(); ++a) data_offsets.push_back({state.arrays[a].name, rows});
    return region.put(group({{"Values", region.put_list(times, {n})},
                             {"PartOffsets", region.put_list(parts.of_step, {n})},
                             {"NumberOfParts", region.put_list(std::vector<std::int64_t>(times.size(), 1), {n})},
                             {"PointOffsets", rows},
                             {"CellOffsets", cells},
                             {"ConnectivityIdOffsets", cells},
                             {"PointDataOffsets", region.put(group(data_offsets, {}))}},
                            {integer_attribute("NSteps", std::span(&n, 1), true)}));
}

}  // namespace

std::vector<std::byte> metadata(SeriesState& state, Address at, Address& root) {
    Region region(at);
    const Parts parts(state);
    const auto n = static_cast<std::int64_t>(parts.rows.size());
    const Address points = put_array(region, state.arrays[0], state);
    Links data;
    for (std::size_t a = 1; a < state.arrays.size(); ++a)
        data.push_back({state.arrays[a].name, put_array(region, state.arrays[a], state)});
    const Address counts = region.put_list(parts.rows, {n}, 3);
    const Address numbers = region.put(dataset({}, {state.vertices_count}, {state.vertices, 0}, {}, 2));
    const Address zeros = region.put_list(std::vector<std::int64_t>(parts.rows.size()), {n}, 3);
    const Address none = region.put(dataset({}, {0}, {}, {}));
    const Address vertices = region.put(group({{"NumberOfCells", counts},
                                               {"NumberOfConnectivityIds", counts},
                                               {"Connectivity", numbers},
                                               {"Offsets", numbers}},
                                              {}));
    const Address no_cells = region.put(group(
        {{"NumberOfCells", zeros}, {"NumberOfConnectivityIds", zeros}, {"Connectivity", none}, {"Offsets", zeros}}, {},
        3));
    const std::int64_t version[] = {2, 0};
    const Address steps = put_steps(region, state, parts);
    const Address top =
        region.put(group({{"NumberOfPoints", counts},
                          {"Points", points},
                          {"PointData", region.put(group(data, {}))},
                          {"Vertices", vertices},
                          {"Lines", no_cells},
                          {"Polygons", no_cells},
                          {"Strips", no_cells},
                          {"Steps", steps}},
                         {integer_attribute("Version", version, false), text_attribute("Type", "PolyData")}));
    root = region.put(group({{"VTKHDF", top}}, {}));
    return region.get();
}

}  // namespace moraine::vtkhdf
