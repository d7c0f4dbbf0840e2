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
        : scene_(scene), comm_(comm), path_(std::move(path)) {
        for (const StructureSpec& s : scene.structures)
            if (turns(s.motion)) width_ = 7;
    }

    /// Where they are now. Collective.
    template <int Dim>
    void append(double time, const StructureSet<Dim>& set) {
        times_.push_back(time);
        for (std::size_t k = 0; k < set.size(); ++k) {
            const StructureState<Dim>& state = set.state(k);
            StructureShift shift;
            for (std::size_t a = 0; a < Dim; ++a) shift.way[a] = state.displacement[static_cast<int>(a)];
            if constexpr (Dim == 3)
                shift.turned = state.turned;
            else
                shift.turned = rotation_by(Vec<double, 3>{{0, 0, state.turned.e[0]}});
            shifts_.push_back(shift);
        }
        if (8 * times_.size() >= 9 * written_) write();
    }

    bool ends_at(double time) const { return !times_.empty() && times_.back() == time; }

    /// What the file lacks. Throws MachineError on all ranks if the disk fails. Collective.
    void write() {
        if (written_ == times_.size()) return;
        comm_.agree_no_error<MachineError>(message_of([&] {
            if (comm_.is_root()) replace_file(path_, moving_image(scene_, times_, shifts_));
        }));
        written_ = times_.size();
    }

    /// For a checkpoint: per output its time, the ways, and how they are turned where one turns.
    std::vector<double> stored() const {
        std::vector<double> rows;
        const std::size_t n = scene_.structures.size();
        for (std::size_t t = 0; t < times_.size(); ++t) {
            rows.push_back(times_[t]);
            for (std::size_t k = t * n; k < (t + 1) * n; ++k) {
                rows.insert(rows.end(), shifts_[k].way.begin(), shifts_[k].way.end());
                if (width_ > 3) rows.insert(rows.end(), shifts_[k].turned.e, shifts_[k].turned.e + 4);
            }
        }
        return rows;
    }

    /// Whether these may be rows of such a run.
    bool restore(const std::vector<double>& rows) {
        const std::size_t n = scene_.structures.size(), width = 1 + width_ * n;
        if (rows.size() % width != 0) return false;
        for (const double x : rows)
            if (!std::isfinite(x)) return false;
        for (auto from = rows.begin(); from != rows.end();) {
            times_.push_back(*from++);
            for (std::size_t k = 0; k < n; ++k, from += static_cast<std::ptrdiff_t>(width_)) {
                StructureShift shift;
                std::copy_n(from, 3, shift.way.begin());
                if (width_ > 3) std::copy_n(from + 3, 4, shift.turned.e);
                shifts_.push_back(shift);
            }
        }
        return true;
    }

  private:
    const Scene& scene_;
    const Comm& comm_;
    std::string path_;
    std::vector<double> times_;           ///< [s]
    std::vector<StructureShift> shifts_;  ///< of all structures, time by time
    std::size_t written_ = 0;             ///< times in the file
    std::size_t width_ = 3;               ///< of a structure in stored(): 7 where one turns
};

}  // namespace moraine
