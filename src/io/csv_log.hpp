#pragma once
// The tables of a run (history.csv, balance.csv): one row a time, on the disk as soon as it is known.
//
// Rank 0 writes. Numbers are the shortest decimals that read back to the same bits. A row is one write,
// so a killed run leaves whole rows, or a last line without its end, which a resumed run drops.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "comm/comm.hpp"
#include "io/disk_file.hpp"

namespace moraine {

/// Where a resumed table goes on: the rows with `column` at most `last` stay.
struct ResumeAfter {
    std::string column;
    double last = 0;
    std::string row = {};  ///< what one of them must be: else the table is of another run; empty: not known
};

/// A number, or a word without a comma.
using CsvCell = std::variant<double, std::string>;

class CsvLog {
  public:
    /// Columns carry their unit in the name (time_s). With `resume` the rows of an existing table are
    /// kept as it says, else the table starts anew. InputError if the table has other columns, or a damaged row among
    /// those that stay. Nothing is written yet. Collective.
    CsvLog(const Comm& comm, std::string path, std::vector<std::string> columns,
           const std::optional<ResumeAfter>& resume = {});

    /// Before the first row: what is kept, on the disk. MachineError if that fails. Collective.
    void begin();
    /// Rank 0's values, one for each column; others may give none. MachineError if the disk fails.
    /// Collective.
    void row(std::span<const CsvCell> values);
    void row(std::span<const double> values);
    /// Several rows, one write. Collective.
    void rows(const std::vector<std::vector<CsvCell>>& list);
    /// The last that this run wrote or kept, without its end; rank 0 knows it, others get none. Not collective.
    const std::string& last_row() const { return last_row_; }

  private:
    std::string kept_rows(const ResumeAfter& resume);

    const Comm& comm_;
    std::string path_;
    std::vector<std::string> columns_;
    std::unique_ptr<DiskFile> file_;  ///< rank 0 only
    std::int64_t end_ = 0;            ///< [byte]
    std::string last_row_;
    std::string content_;  ///< until begin()
};

}  // namespace moraine
