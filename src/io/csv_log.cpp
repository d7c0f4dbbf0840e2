#include "io/csv_log.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/data/error.hpp"

namespace moraine {

namespace {

/// The number in field `column` of a row that has `count` fields; none if it is torn or no row.
std::optional<double> field(const std::string& row, std::size_t column, std::size_t count) {
    if (std::any_of(row.begin(), row.end(), [](unsigned char c) { return c < ' '; })) return {};
    if (static_cast<std::size_t>(std::count(row.begin(), row.end(), ',')) + 1 != count) return {};
    std::size_t at = 0;
    for (std::size_t c = 0; c < column; ++c) at = row.find(',', at) + 1;
    double value = 0;
    const auto end = std::from_chars(row.data() + at, row.data() + row.size(), value);
    if (end.ec != std::errc()) return {};
    return value;
}

}  // namespace

CsvLog::CsvLog(const Comm& comm, std::string path, std::vector<std::string> columns,
               const std::optional<ResumeAfter>& resume)
    : comm_(comm), path_(std::move(path)), columns_(std::move(columns)) {
    content_ = fmt::format("{}\n", fmt::join(columns_, ","));
    comm.agree_no_error<InputError>(message_of([&] {
        if (comm.is_root() && resume && std::filesystem::exists(path_)) content_ += kept_rows(*resume);
    }));
}

void CsvLog::begin() {
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (!comm_.is_root()) return;
        replace_file(path_, content_);
        file_ = std::make_unique<DiskFile>(path_, DiskFile::Mode::append);
        end_ = static_cast<std::int64_t>(content_.size());
        content_.clear();
    }));
}

std::string CsvLog::kept_rows(const ResumeAfter& resume) {
    const auto column =
        static_cast<std::size_t>(std::find(columns_.begin(), columns_.end(), resume.column) - columns_.begin());
    std::ifstream file(path_);
    std::string line;
    if (!std::getline(file, line) || line != fmt::format("{}", fmt::join(columns_, ",")))
        throw InputError(fmt::format("cannot continue {} (its columns are others). Another --output?", path_));
    std::string rows;
    bool known = resume.row.empty();
    int damaged = 0;
    for (int number = 2; std::getline(file, line); ++number) {
        if (file.eof()) break;  // the last line has no end: its write was cut short
        const auto value = field(line, column, columns_.size());
        if (!value && damaged == 0) damaged = number;
        if (!value || *value > resume.last) continue;
        if (damaged > 0)  // what lies behind the checkpoint goes anyway
            throw InputError(
                fmt::format("cannot continue {} (line {} is damaged). Mend or remove the line, or another --output?",
                            path_, damaged));
        rows += line + '\n';
        last_row_ = line;
        known = known || line == resume.row;
    }
    if (!known && !rows.empty())
        throw InputError(
            fmt::format("cannot continue {} (it lacks the row that was its last when the checkpoint was written: it is "
                        "of another run). Another --output?",
                        path_));
    return rows;
}

void CsvLog::row(std::span<const double> values) {
    row(std::vector<CsvCell>(values.begin(), values.end()));
}

void CsvLog::row(std::span<const CsvCell> values) {
    rows({{values.begin(), values.end()}});
}

void CsvLog::rows(const std::vector<std::vector<CsvCell>>& list) {
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (!comm_.is_root()) return;
        std::string lines;
        for (const std::vector<CsvCell>& row : list) {
            if (row.size() != columns_.size()) throw std::logic_error(path_ + ": a row of another length");
            std::vector<std::string> words;
            for (const CsvCell& cell : row)
                words.push_back(std::visit([](const auto& value) { return fmt::format("{}", value); }, cell));
            last_row_ = fmt::format("{}", fmt::join(words, ","));
            lines += last_row_ + '\n';
        }
        file_->write(std::as_bytes(std::span(lines)), end_);
        end_ += static_cast<std::int64_t>(lines.size());
    }));
}

}  // namespace moraine
