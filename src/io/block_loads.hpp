#pragma once
// block_loads.bin: what every occupied block weighed and who held it, at the start and at each balance interval.
//
//   header   what a replay must know of the run: layout, message sizes, rules of balance; a hash over it
//   frame    step, time, seconds lost to imbalance, exchanges of the halo; of each rank its seconds per phase since the
//            frame before (32 bytes); of each block its key, particles, owner, and whether it sleeps (16 bytes), in key
//            order; a hash over all of it
//
// Rank 0 writes, a frame by one write, so a killed run leaves whole frames and at most one torn frame at the end. A
// reader refuses a torn or damaged frame; that whole frames are missing is told by balance.csv, which
// gets its row after the frame is written. Not HDF5: a file that grows for hours must stay readable after a kill
// without a flush of its metadata at every frame.

#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "core/data/morton.hpp"
#include "io/disk_file.hpp"

namespace moraine {

/// What a record says of sleeping blocks.
enum class SleepersRecord : std::int32_t {
    none,    ///< nothing: all count as awake
    asleep,  ///< which of them sleep: of a run with numerics.sleep = "on"
    would    ///< which of them would: of a run in which all are awake
};

/// In the byte order of the machine that wrote it. Axes that the scene does not have: 1 block.
struct LoadHeader {
    std::array<char, 8> magic{'M', 'O', 'R', 'L', 'O', 'A', 'D', '5'};
    std::int32_t dimensions = 3;
    std::int32_t width = 3;                  ///< of the stencil [nodes]
    std::array<std::int32_t, 3> blocks{};    ///< of the domain
    std::array<std::int32_t, 3> periodic{};  ///< 0 or 1
    std::int32_t node_bytes = 40;            ///< of a node in a message of the halo
    std::int32_t rounds = 1;                 ///< of the method (core/transfer/method.hpp)
    std::int32_t interval = 50;              ///< [steps] between imbalance checks
    std::int32_t axis = 0;                   ///< of slabs
    std::int32_t trigger = 0;                ///< Trigger as a number
    std::int32_t weighs_cost = 0;            ///< 1: blocks weigh what they cost, 0: particles
    std::int32_t sleepers = 0;               ///< who sleeps: SleepersRecord as a number
    std::int32_t unused = 0;                 ///< fills eight bytes
    double threshold = 1.05;                 ///< of the trigger
    std::array<std::int64_t, 2> model{};     ///< cost of a step per particle and block [ps]
    std::array<double, 3> corner{};          ///< lower corner of block (0, 0, 0) [m]
    double block_side = 0;                   ///< [m]
    std::array<char, 24> partitioner{};      ///< its name
    std::array<double, 2> moves{};           ///< cost of a migration: of any, per particle of the busiest rank [s]
    std::uint64_t hash = 0;                  ///< of all before it; the writer sets it
};
static_assert(sizeof(LoadHeader) == 176);

struct LoadRow {
    Key key;
    std::uint32_t particles : 31;
    std::uint32_t asleep : 1;  ///< LoadHeader::sleepers says in which sense
    std::int32_t owner;
};
static_assert(sizeof(LoadRow) == 16);

/// Of one rank, phase by phase in the order of phases.hpp [s].
using RankSeconds = std::array<float, 8>;

struct LoadFrame {
    std::int64_t step = 0;
    double time = 0;                   ///< simulated [s]
    double lost = 0;                   ///< computing of the slowest rank less mean, summed over steps since then [s]
    std::int64_t exchanges = 0;        ///< of the halo since the frame before: of rounds and of substeps
    std::vector<RankSeconds> seconds;  ///< of each rank, since the frame before
    std::vector<LoadRow> rows;         ///< in key order
};

class BlockLoadWriter {
  public:
    /// With `resume_step` the frames up to that step stay, if the file is whole; else it starts anew. Throws
    /// MachineError if the disk fails, InputError if the file to resume is of another domain
    /// or says otherwise who sleeps. Collective.
    BlockLoadWriter(const Comm& comm, std::string path, const LoadHeader& header,
                    std::optional<std::int64_t> resume_step = {});

    /// Rank 0's frame; one of a step that is there already is left out. Collective.
    void write(const LoadFrame& frame);

  private:
    void take_over(const LoadHeader& header, std::int64_t resume_step);

    const Comm& comm_;
    std::string path_;
    std::unique_ptr<DiskFile> file_;  ///< rank 0 only
    std::int64_t end_ = 0;            ///< [byte]
    std::int64_t last_step_ = -1;
};

/// Frame after frame: no more than one is in memory. Throws InputError. Not collective.
class BlockLoadReader {
  public:
    explicit BlockLoadReader(const std::string& path);

    const LoadHeader& header() const { return header_; }

    /// False at the end of the file. A frame that is torn or damaged is an InputError.
    bool next(LoadFrame& frame);

    /// Where the next frame begins [byte].
    std::int64_t position() const { return position_; }

  private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    [[noreturn]] void refuse(const std::string& why) const;

    std::string path_;
    std::unique_ptr<std::FILE, Close> file_;
    LoadHeader header_;
    std::int64_t size_ = 0, position_ = 0, last_step_ = -1;  // [byte], [byte], of the last whole frame
};

}  // namespace moraine
