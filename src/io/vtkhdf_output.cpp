#include "io/vtkhdf_output.hpp"

#include <cstring>
#include <numeric>

#include "io/deflate.hpp"

namespace moraine::vtkhdf {

namespace {

/// Rows of two numbers to rows of three.
std::vector<std::byte> with_zero(const std::vector<std::byte>& rows, std::size_t number_bytes) {
    const std::size_t count = rows.size() / (2 * number_bytes);
    std::vector<std::byte> wide(count * 3 * number_bytes);
    for (std::size_t r = 0; r < count; ++r)
        std::memcpy(wide.data() + r * 3 * number_bytes, rows.data() + r * 2 * number_bytes, 2 * number_bytes);
    return wide;
}

}  // namespace

SeriesOutput::SeriesOutput(const OutputPlan& plan, const std::string& path, std::span<const Column> columns,
                           std::int64_t rows, const RowRange& slice)
    : plan_(plan), path_(path), rows_(rows), slice_(slice), chunks_(columns.size()), end_(plan.at) {
    const std::int64_t count = (rows + plan.chunk_rows - 1) / plan.chunk_rows;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        columns_.push_back({columns[c].name, columns[c].unit, columns[c].type, columns[c].components});
        for (std::int64_t k = 0; k < count; ++k) {
            chunks_[c].push_back({k, end_});
            end_ += static_cast<Address>(plan.chunk_rows * row_bytes(c));
        }
    }
}

std::int64_t SeriesOutput::row_bytes(std::size_t column) const {
    const std::int64_t numbers = components_in_file(columns_[column]);
    return numbers * Column::bytes_of(columns_[column].type);
}

void SeriesOutput::take(std::vector<std::byte> slice) {
    const std::size_t c = taken_++;
    if (columns_[c].components == 2)
        slice = with_zero(slice, static_cast<std::size_t>(Column::bytes_of(columns_[c].type)));
    if (!plan_.deflate) return pieces_.push_back({c, slice_.start, std::move(slice)});
    for (std::int64_t row = 0; row < slice_.count; row += plan_.chunk_rows) {
        const auto begin = slice.begin() + row * row_bytes(c);
        const std::int64_t here = std::min(plan_.chunk_rows, slice_.count - row);
        pieces_.push_back({c, slice_.start + row, {begin, begin + here * row_bytes(c)}});
    }
}

void SeriesOutput::deflate(Piece& piece) const {
    if (piece.deflated) return;
    piece.bytes.resize(static_cast<std::size_t>(plan_.chunk_rows * row_bytes(piece.column)));  // a chunk is whole
    piece.bytes = deflated(piece.bytes, static_cast<std::size_t>(Column::bytes_of(columns_[piece.column].type)));
    piece.deflated = true;
}

void SeriesOutput::deflate(int threads) {
    if (!plan_.deflate) return;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (Piece& piece : pieces_) {
        const std::string trouble = message_of([&] { deflate(piece); });
#pragma omp critical
        if (!trouble.empty()) trouble_ = trouble;
    }
}

void SeriesOutput::place(const Comm& comm) {
    if (!plan_.deflate) return;
    std::vector<std::int64_t> mine;
    for (const Piece& piece : pieces_) mine.push_back(static_cast<std::int64_t>(piece.bytes.size()));
    const std::vector<std::int64_t> all = comm.all_gather(mine);
    auto bytes = all.begin();
    for (int r = 0; r < comm.size(); ++r) {
        const RowRange slice = slice_of(rows_, plan_.chunk_rows, r, comm.size());
        for (std::vector<Chunk>& chunks : chunks_)
            for (std::int64_t row = slice.start; row < slice.start + slice.count; row += plan_.chunk_rows)
                chunks[static_cast<std::size_t>(row / plan_.chunk_rows)].bytes = *bytes++;
    }
    end_ = plan_.at;
    for (std::vector<Chunk>& chunks : chunks_)
        for (Chunk& chunk : chunks) {
            chunk.at = end_;
            end_ += static_cast<Address>(chunk.bytes);
        }
    end_ = (end_ + 7) / 8 * 8;
}

void SeriesOutput::open() {
    if (!file_) file_ = std::make_unique<DiskFile>(path_, DiskFile::Mode::append);
}

void SeriesOutput::write() {
    if (trouble_.empty())
        trouble_ = message_of([&] {
            open();
            for (Piece& piece : pieces_) {
                const std::size_t k = chunk_of(piece);
                const std::int64_t within =
                    (piece.row - static_cast<std::int64_t>(k) * plan_.chunk_rows) * row_bytes(piece.column);
                if (piece.bytes.empty()) continue;
                file_->write(piece.bytes, static_cast<std::int64_t>(chunks_[piece.column][k].at) + within);
                std::vector<std::byte>().swap(piece.bytes);
            }
        });
    pieces_.clear();
}

void SeriesOutput::finish() {
    if (!trouble_.empty()) return;
    trouble_ = message_of([&] {
        open();
        if (plan_.vertices > 0) {
            const bool last = slice_.start + slice_.count == rows_;
            std::vector<std::int64_t> numbers(static_cast<std::size_t>(slice_.count + (last ? 1 : 0)));
            std::iota(numbers.begin(), numbers.end(), slice_.start);
            file_->write(std::as_bytes(std::span(numbers)), static_cast<std::int64_t>(end_) + slice_.start * 8);
        }
        file_->sync();
    });
}

}  // namespace moraine::vtkhdf
