#pragma once
// One output of a particle series on its way into the file (io/vtkhdf.hpp).
//
// A rank has a slice of the rows of each column, in the order of the file: written at once where chunks are stored as
// they are, for their places are known. Compressed ones have places only when all ranks have told how long theirs have
// become; there a slice is of whole chunks, so that the bytes do not depend on the ranks. Places follow each other
// column by column, chunk by chunk.
// What fails is kept as a message until all ranks ask for it: others may be waiting in an exchange.

#include <memory>
#include <string>
#include <vector>

#include "io/disk_file.hpp"
#include "io/row_order.hpp"
#include "io/vtkhdf_state.hpp"

namespace moraine::vtkhdf {

/// Where the next output goes: known to rank 0, told to all.
struct OutputPlan {
    Address at = 0;
    std::int64_t chunk_rows = 0;
    std::int64_t vertices = 0;  ///< numbers of vertices to write; 0: those of an earlier output suffice
    bool first = true;          ///< there is no file yet: write under a temporary name
    bool deflate = false;       ///< compress the chunks
    bool failed = false;        ///< rank 0 cannot write there
};

class SeriesOutput {
  public:
    /// Of `rows` in all, mine are `slice`. Not collective, as all members but place().
    SeriesOutput(const OutputPlan& plan, const std::string& path, std::span<const Column> columns, std::int64_t rows,
                 const RowRange& slice);

    /// My slice of the next column.
    void take(std::vector<std::byte> slice);
    /// Compresses what was taken on so many threads, or does nothing. Never throws.
    void deflate(int threads);
    /// Finds the places of compressed chunks, or does nothing. Collective.
    void place(const Comm& comm);
    /// Writes what was taken, and forgets it; then, at the end, the numbers of vertices. Never throw.
    void write();
    void finish();

    const std::string& trouble() const { return trouble_; }
    const OutputPlan& plan() const { return plan_; }
    std::int64_t rows() const { return rows_; }
    /// Name, unit and type of the columns, without rows, and their chunks, numbered from the first of this output.
    const std::vector<Column>& columns() const { return columns_; }
    const std::vector<std::vector<Chunk>>& chunks() const { return chunks_; }
    /// Behind the last chunk: there stand the numbers of vertices.
    Address vertices_at() const { return end_; }

  private:
    struct Piece {
        std::size_t column;
        std::int64_t row;  ///< in the file's order, within the output
        std::vector<std::byte> bytes;
        bool deflated = false;
    };

    std::int64_t row_bytes(std::size_t column) const;
    std::size_t chunk_of(const Piece& piece) const { return static_cast<std::size_t>(piece.row / plan_.chunk_rows); }
    void deflate(Piece& piece) const;
    void open();

    OutputPlan plan_;
    std::string path_;
    std::vector<Column> columns_;
    std::int64_t rows_;
    RowRange slice_;
    std::size_t taken_ = 0;  ///< columns
    std::vector<Piece> pieces_;
    std::vector<std::vector<Chunk>> chunks_;  ///< by column
    Address end_ = 0;
    std::unique_ptr<DiskFile> file_;
    std::string trouble_;
};

}  // namespace moraine::vtkhdf
