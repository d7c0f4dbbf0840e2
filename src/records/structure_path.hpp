#pragma once
// structures.vtkhdf as a run goes on: where structures were at the outputs so far.
//
// The file is written anew as a whole, when outputs have become an eighth more, with checkpoints and at the end: what
// is written in all is some ten times the file at most, and a run under way is shown but for its last outputs. The
// rows are in checkpoints, so that a restart goes on with them.

#include <cmath>

#include "io/disk_file.hpp"
#include "records/surroundings_file.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

/// The same on all ranks; rank 0 writes.
class StructurePath {
  public:
    StructurePath(const Scene& scene, const Comm& comm, std::string path)
        : scene_(scene), comm_(comm), path_(std::move(path)) {}

    /// Where they are now. Collective.
    template <int Dim>
    void append(double time, const StructureSet<Dim>& set) {
        times_.push_back(time);
        for (std::size_t k = 0; k < set.size(); ++k) {
            Triple way{};
            for (std::size_t a = 0; a < Dim; ++a) way[a] = set.state(k).displacement[static_cast<int>(a)];
            ways_.push_back(way);
        }
        if (8 * times_.size() >= 9 * written_) write();
    }

    bool ends_at(double time) const { return !times_.empty() && times_.back() == time; }

    /// What the file lacks. Throws MachineError on all ranks if the disk fails. Collective.
    void write() {
        if (written_ == times_.size()) return;
        comm_.agree_no_error<MachineError>(message_of([&] {
            if (comm_.is_root()) replace_file(path_, moving_image(scene_, times_, ways_));
        }));
        written_ = times_.size();
    }

    /// For a checkpoint: per output its time and the ways.
    std::vector<double> stored() const {
        std::vector<double> rows;
        const std::size_t n = scene_.structures.size();
        for (std::size_t t = 0; t < times_.size(); ++t) {
            rows.push_back(times_[t]);
            for (std::size_t k = 0; k < n; ++k)
                rows.insert(rows.end(), ways_[t * n + k].begin(), ways_[t * n + k].end());
        }
        return rows;
    }

    /// Whether these may be rows of such a run.
    bool restore(const std::vector<double>& rows) {
        const std::size_t n = scene_.structures.size(), width = 1 + 3 * n;
        if (rows.size() % width != 0) return false;
        for (const double x : rows)
            if (!std::isfinite(x)) return false;
        for (std::size_t at = 0; at < rows.size(); at += width) {
            times_.push_back(rows[at]);
            for (std::size_t k = 0; k < n; ++k)
                ways_.push_back({rows[at + 1 + 3 * k], rows[at + 2 + 3 * k], rows[at + 3 + 3 * k]});
        }
        return true;
    }

  private:
    const Scene& scene_;
    const Comm& comm_;
    std::string path_;
    std::vector<double> times_;  ///< [s]
    std::vector<Triple> ways_;   ///< of all structures, time by time [m]
    std::size_t written_ = 0;    ///< times in the file
};

}  // namespace moraine
