#pragma once
// particles.vtkhdf: the particles at each output time, one file that ParaView and VTK open while the
// run still writes it. Format: VTKHDF 2.0, temporal PolyData, a vertex per particle.
//
// Invariant: the file is complete and readable at any moment. Rows of an output are appended past the
// end that the superblock names, then new metadata, and when all of that is on the disk one write of
// 48 bytes makes both valid. Nothing that an older superblock points to is ever written again, so a
// reader that has the file open keeps a consistent view. A kill loses at most the output being written.
// Price: the metadata of each output stays in the file (about 0.1 MB at 1000 outputs of 10 fields).

#include <functional>
#include <future>
#include <memory>
#include <string>

#include "io/row_order.hpp"
#include "io/vtkhdf_output.hpp"
#include "io/vtkhdf_state.hpp"

namespace moraine {

/// Which of the arrays `rank` and `block_key` an output has besides its fields.
struct SeriesLabels {
    bool rank = true, block_key = true;
};

struct SeriesOptions {
    bool deflate = false;       ///< compress the chunks of outputs from now on (io/deflate.hpp)
    bool asynchronous = false;  ///< a thread of its own compresses and writes them
};

class ParticleSeries {
  public:
    /// Goes on with the file if there is one (InputError if it is something else); else the first
    /// append makes it. Collective.
    ParticleSeries(const Comm& comm, std::string path, const SeriesOptions& options = {});

    /// Drops the outputs later than `time` [s]. Collective.
    void truncate_to(double time);

    /// Throws InputError on all ranks if an array of the file has numbers of another type than the column of its name:
    /// such an output could not be appended. Collective.
    void check_types(const Column& position, std::span<const Column> fields) const;

    /// One output. Rows of all columns: my blocks (ascending by key) in order. Two components become
    /// three, the last zero. Arrays `rank` and `block_key` are added as `labels` says. A field may be new or gone since
    /// the last output: where it was not written it reads as NaN, or 0 of integers. Throws MachineError
    /// on all ranks if the disk fails; the earlier outputs stay. What is asynchronous is only begun, once the output
    /// before it is through: the rows of one are in memory at a time. Collective.
    void append(double time, std::span<const BlockRow> my_blocks, const Column& position,
                std::span<const Column> fields, const SeriesLabels& labels = {});

    /// Whether an output is under way: the same on all ranks. Not collective.
    bool under_way() const { return stage_ != Stage::none; }
    /// Whether this rank is at work on it. Not collective.
    bool busy() const;
    /// Goes on with the output under way; waits for nobody if no rank is busy. Throws as append() does. Collective.
    void advance();
    /// Ends it. Collective.
    void finish();

    /// Times of the outputs in the file [s]; rank 0 knows them, others get none. Not collective.
    std::vector<double> times() const;

  private:
    std::vector<Column> columns_of(std::span<const BlockRow> my_blocks, const Column& position,
                                   std::span<const Column> fields, const SeriesLabels& labels) const;
    vtkhdf::OutputPlan plan(std::int64_t rows) const;
    void check_ours() const;
    void record(const vtkhdf::SeriesOutput& output, double time);
    void end_if_trouble();
    void commit(vtkhdf::SeriesState next, vtkhdf::Address from, const std::string& path);

    const Comm& comm_;
    std::string path_;
    SeriesOptions options_;
    vtkhdf::SeriesState state_;    ///< rank 0's is the true one
    std::vector<std::byte> head_;  ///< the superblock as this run found or left it; rank 0's

    enum class Stage { none, compress, write, commit };
    void begin(Stage stage, std::function<void()> work);
    std::unique_ptr<vtkhdf::SeriesOutput> output_;  ///< under way
    double time_ = 0;                               ///< of it [s]
    Stage stage_ = Stage::none;
    std::string trouble_;
    std::future<void> work_;  ///< the last member: it ends before the others do
};

}  // namespace moraine
