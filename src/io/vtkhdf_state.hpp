#pragma once
// What is in a particle series: times, arrays and where their chunks lie. Rank 0 keeps it; it becomes
// the HDF5 metadata of each commit, and is read back from the file when a run goes on.
//
// Each output starts a new chunk in every array, so its rows are consecutive chunks; rows that pad its
// last chunk belong to nobody and are never written. An array that an output lacks has no chunk there.

#include <string>
#include <vector>

#include "io/hdf5_image.hpp"

namespace moraine::vtkhdf {

using hdf5::Address;
using hdf5::Chunk;

struct SeriesArray {
    std::string name;
    std::string unit;
    Column::Type type = Column::Type::f64;
    int components = 1;
    std::vector<Chunk> chunks = {};
    std::vector<Chunk> full_nodes = {};  ///< leaves of the chunk tree that no longer change, on the disk

    int row_bytes() const { return components * Column::bytes_of(type); }
};

struct SeriesStep {
    double time = 0;
    std::int64_t rows = 0;
    std::int64_t first_chunk = 0;
};

struct SeriesState {
    std::int64_t chunk_rows = 0;
    bool filtered = false;  ///< some chunks are compressed; which, they tell
    std::vector<SeriesStep> steps;
    std::vector<SeriesArray> arrays;   ///< Points first
    Address vertices = hdf5::nowhere;  ///< 0, 1, 2, ...: connectivity and offsets of the vertices of every step
    std::int64_t vertices_count = 0;
    Address end = hdf5::superblock_bytes;  ///< of what is committed

    std::int64_t chunks_of(std::int64_t rows) const { return (rows + chunk_rows - 1) / chunk_rows; }
    std::int64_t next_chunk() const {
        return steps.empty() ? 0 : steps.back().first_chunk + chunks_of(steps.back().rows);
    }
};

/// Components of a column in the file: vectors of two become three.
inline int components_in_file(const Column& column) {
    return column.components == 2 ? 3 : column.components;
}

/// Metadata that describes `state`, to be written at `at`; sets `root` and remembers full nodes.
std::vector<std::byte> metadata(SeriesState& state, Address at, Address& root);

/// The state of the series at `path`. Throws H5Failure if it is not one.
SeriesState read_state(const std::string& path);

}  // namespace moraine::vtkhdf
