#include "app/run_directory.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "core/data/error.hpp"
#include "io/disk_file.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {

namespace fs = std::filesystem;

namespace {

bool is_checkpoint(const std::string& name) {
    return name.starts_with("checkpoint-") && name.ends_with(".h5");
}

/// A file that says: there was a run here.
bool tells_of_run(const std::string& name) {
    return name == "summary.json" || name == "history.csv" || name == "particles.vtkhdf" || name == "cells.vtkhdf" ||
           is_checkpoint(name);
}

bool is_made_by_run(const std::string& name) {
    return tells_of_run(name) || name == "balance.csv" || name == "scene.json" || name == "surroundings.vtkhdf" ||
           name == "structures.vtkhdf" || name == "block_loads.bin" || name == "replay.csv" ||
           name == "structures.csv" || name == "gauges.csv" || name == "sections.csv";
}

/// A file that a run was writing when it was killed.
bool is_unfinished(const std::string& name) {
    constexpr std::string_view partial = ".partial";
    return name.ends_with(partial) && is_made_by_run(name.substr(0, name.size() - partial.size()));
}

bool belongs_to_run(const std::string& name) {
    return is_made_by_run(name) || is_unfinished(name);
}

std::vector<fs::path> files_of_run(const fs::path& path, bool (*which)(const std::string&)) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path))
        if (entry.is_regular_file() && which(entry.path().filename().string())) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

[[noreturn]] void not_writable(const fs::path& path, const std::string& why) {
    throw InputError(fmt::format("cannot write into {} ({}). Another --output?", path.string(), why));
}

/// The directory itself, or the nearest one above it that exists.
fs::path nearest_existing(fs::path path) {
    path = fs::absolute(path);
    while (!fs::exists(path) && path.has_relative_path()) path = path.parent_path();
    return path;
}

void check(const fs::path& path, RunClaim claim) {
    try {
        const fs::path existing = nearest_existing(path);
        if (!fs::is_directory(existing)) not_writable(path, existing.string() + " is not a directory");
        if (::access(existing.c_str(), W_OK | X_OK) != 0) not_writable(path, std::strerror(errno));
        if (!fs::exists(path)) return;
        RunLock::check_free(path.string());
        if (claim != RunClaim::fresh) return;
        const auto files = files_of_run(path, tells_of_run);
        if (!files.empty())
            throw InputError(fmt::format("{} holds a run (it has {}). --overwrite, or another --output?", path.string(),
                                         files[0].filename().string()));
    } catch (const fs::filesystem_error& error) {
        not_writable(path, error.code().message());
    }
}

/// A file of the folder maps that a run made.
bool is_map(const std::string& name) {
    const std::vector<std::string>& maps = hazard_map_names();
    const fs::path file = name;
    const std::string end = file.extension().string(), stem = file.stem().string();
    if (end == ".partial") return is_map(stem);
    if (stem == "outline") return end == ".gpkg" || end == ".geojson";
    return (end == ".tif" || end == ".asc" || end == ".qml") && std::find(maps.begin(), maps.end(), stem) != maps.end();
}

/// What a run before left of its maps.
void remove_maps(const fs::path& path) {
    if (!fs::is_directory(path / "maps")) return;
    for (const auto& file : files_of_run(path / "maps", is_map)) fs::remove(file);
    std::error_code not_empty;
    fs::remove(path / "maps", not_empty);
}

RunLock claim_it(const fs::path& path, RunClaim claim) {
    std::vector<fs::path> made;  // deepest first
    for (fs::path p = fs::absolute(path); !fs::exists(p) && p.has_relative_path(); p = p.parent_path())
        if (p.has_filename()) made.push_back(p);
    try {
        fs::create_directories(path);
        RunLock lock(path.string());
        const auto removed = claim == RunClaim::overwrite ? belongs_to_run : is_unfinished;
        for (const auto& file : files_of_run(path, removed)) fs::remove(file);
        if (claim == RunClaim::overwrite) remove_maps(path);
        const fs::path probe = path / "summary.json.partial";  // the permission bits are not the whole truth
        DiskFile(probe.string(), DiskFile::Mode::create);
        fs::remove(probe);
        return lock;
    } catch (const std::exception& error) {
        const int why = errno;
        std::error_code ignored;
        for (const fs::path& p : made) fs::remove(p, ignored);  // one that another run has taken is not empty
        if (dynamic_cast<const InputError*>(&error)) throw;
        const auto* failure = dynamic_cast<const fs::filesystem_error*>(&error);
        not_writable(path, failure ? failure->code().message() : std::strerror(why));
    }
}

}  // namespace

std::string default_run_directory(const std::string& scene_name) {
    if (scene_name == "." || scene_name == "..")
        throw InputError(
            fmt::format("a scene called {0}.toml has no directory of its own (runs/{0} is another). Give it another "
                        "name, or --output?",
                        scene_name));
    return "runs/" + scene_name;
}

void check_run_directory(const Comm& comm, const std::string& path, RunClaim claim) {
    comm.agree_no_error<InputError>(message_of([&] {
        if (comm.is_root()) check(path, claim);
    }));
}

RunLock claim_run_directory(const Comm& comm, const std::string& path, RunClaim claim) {
    RunLock lock;
    comm.agree_no_error<InputError>(message_of([&] {
        if (!comm.is_root()) return;
        check(path, claim);
        lock = claim_it(path, claim);
    }));
    return lock;
}

}  // namespace moraine
