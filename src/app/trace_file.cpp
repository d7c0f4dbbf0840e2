#include "app/trace_file.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <span>
#include <vector>

#include "comm/phases.hpp"
#include "comm/point_to_point.hpp"
#include "core/data/error.hpp"
#include "io/disk_file.hpp"
#include "io/json_text.hpp"
#include "records/version.hpp"

namespace moraine {

namespace {

namespace fs = std::filesystem;

/// Empty, or why it cannot be written.
std::string hindrance(const fs::path& path, const fs::path& directory, bool overwrite) {
    std::error_code none;
    const fs::path folder = path.parent_path().empty() ? "." : path.parent_path();
    if (!path.has_filename() || fs::is_directory(path, none)) return "it is a folder). Name a file in it?";
    if (fs::exists(path, none) && !overwrite) return "it is there). --overwrite, or another name?";
    if (fs::weakly_canonical(folder, none) == fs::weakly_canonical(directory, none)) return {};  // the run makes it
    if (!fs::is_directory(folder, none)) return fmt::format("{} is no folder). Make it first?", folder.string());
    const std::string trial = path.string() + ".partial";  // as it will be written
    const std::string wrong = message_of([&] { DiskFile(trial, DiskFile::Mode::create); });
    fs::remove(trial, none);
    return wrong.empty() ? "" : fmt::format("no file can be made in {}). Another folder?", folder.string());
}

/// One event a line.
std::string events_of(Timeline& timeline, int rank, const std::string& device) {
    const std::vector<Span>& spans = timeline.sorted();
    const std::string process = Json(fmt::format("rank {} on {}", rank, device)).text();
    std::string text =
        fmt::format(R"({{"name":"process_name","ph":"M","pid":{},"tid":0,"args":{{"name":{}}}}})", rank, process);
    text += fmt::format(
        ",\n"
        R"({{"name":"process_sort_index","ph":"M","pid":{0},"tid":0,"args":{{"sort_index":{0}}}}})",
        rank);
    text.reserve(text.size() + 128 * spans.size());
    for (const Span& span : spans)
        fmt::format_to(
            std::back_inserter(text),
            FMT_COMPILE(
                ",\n"
                R"({{"name":"{}","cat":"{}","ph":"X","ts":{}.{:03},"dur":{}.{:03},"pid":{},"tid":0,"args":{{"step":{}}}}})"),
            span.name.text, span.phase < 0 ? "run" : Phases::names[static_cast<std::size_t>(span.phase)],
            span.begin / 1000, span.begin % 1000, span.length / 1000, span.length % 1000, rank, span.step);
    return text;
}

}  // namespace

std::size_t spans_of_rank(int ranks) {
    return std::min<std::size_t>(std::size_t(1) << 16, (std::size_t(1) << 20) / static_cast<std::size_t>(ranks));
}

void check_trace_file(const Comm& comm, const std::string& path, const std::string& directory, bool overwrite) {
    const std::string why = comm.is_root() ? hindrance(path, directory, overwrite) : "";
    comm.agree_no_error<InputError>(why.empty() ? "" : fmt::format("--trace {} cannot be written ({}", path, why));
}

void write_trace(const Comm& comm, const std::string& path, Timeline& mine, const std::string& scene,
                 const std::string& device) {
    mine.thin(comm.max(mine.stride()));
    const std::int64_t lost = comm.sum(mine.lost());
    const std::string text = events_of(mine, comm.rank(), device);
    std::vector<std::vector<std::byte>> parcels(static_cast<std::size_t>(comm.size()));
    const auto bytes = std::as_bytes(std::span(text));
    if (!comm.is_root()) parcels.front().assign(bytes.begin(), bytes.end());
    const std::vector<std::vector<std::byte>> all = exchange_all(comm, parcels);
    comm.agree_no_error<MachineError>(message_of([&] {
        if (!comm.is_root()) return;
        replace_file_by(path, [&](const auto& write) {
            const Json head = Json::Named{{"version", version_text}, {"commit", commit_text},   {"scene", scene},
                                          {"ranks", comm.size()},    {"stride", mine.stride()}, {"lost", lost}};
            write(fmt::format("{{\"displayTimeUnit\": \"ms\",\n\"otherData\": {},\n\"traceEvents\": [\n", head.text()));
            write(text);
            for (const std::vector<std::byte>& part : all) {
                if (part.empty()) continue;
                write(",\n");
                write({reinterpret_cast<const char*>(part.data()), part.size()});
            }
            write("\n]}\n");
        });
    }));
}

}  // namespace moraine
