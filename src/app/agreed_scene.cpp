#include "app/agreed_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

#include "compile/system_compiler.hpp"
#include "core/data/error.hpp"
#include "core/data/hash.hpp"
#include "records/version.hpp"
#include "scene/read_scene.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_identity.hpp"

namespace moraine {
namespace {

/// Something that every rank has of its own and that must be the same on all.
struct Common {
    std::string what;
    std::uint64_t hash;
    std::string remedy;
};

std::uint64_t hash_of(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return mix_bytes(mix(bytes.size()), bytes.data(), bytes.size());
}

/// Throws InputError that names the first thing of which rank 0 has another than others, and these. Collective.
void agree_on(const Comm& comm, const std::string& scene, const std::vector<Common>& things) {
    std::vector<std::uint64_t> mine;
    for (const Common& thing : things) mine.push_back(thing.hash);
    std::vector<std::int64_t> counts;
    const std::vector<std::uint64_t> all = comm.all_gather(mine, &counts);
    if (std::count(counts.begin(), counts.end(), counts[0]) != comm.size())
        throw InputError(fmt::format("{}: ranks read scenes of another length (it must be the same on all). {}", scene,
                                     things.back().remedy));
    for (std::size_t k = 0; k < things.size(); ++k) {
        std::vector<int> others;
        for (int rank = 1; rank < comm.size(); ++rank)
            if (all[static_cast<std::size_t>(rank) * things.size() + k] != all[k]) others.push_back(rank);
        if (others.empty()) continue;
        const std::size_t named = std::min<std::size_t>(others.size(), 8);
        throw InputError(
            fmt::format("{}: rank 0 and rank{} {}{} differ in {} (it must be the same on all ranks). {}", scene,
                        others.size() == 1 ? "" : "s",
                        fmt::join(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(named), ", "),
                        others.size() > named ? ", ..." : "", things[k].what, things[k].remedy));
    }
}

/// Agrees on what is wrong with the input, if anything is, or with a machine that lacks a library; that memory ran out
/// is for main. Collective.
template <class Action>
void agree_input(const Comm& comm, Action&& action) {
    std::string wrong, refused, failed;
    try {
        action();
    } catch (const CompilerError& error) {
        refused = error.what();
    } catch (const InputError& error) {
        wrong = error.what();
    } catch (const MachineError& error) {
        failed = error.what();
    }
    comm.agree_no_error<CompilerError>(refused);
    comm.agree_no_error<InputError>(wrong);
    comm.agree_no_error<MachineError>(failed);
}

std::vector<std::string> all_sets(const Options& options) {
    std::vector<std::string> sets = options.sets;
    if (!options.partitioner.empty()) sets.push_back("balance.partitioner=\"" + options.partitioner + "\"");
    return sets;
}

/// What was read of files, by its values: it may have come through a file that names others. Tables of particles are
/// read when they are seeded.
std::vector<Common> values_of(const Scene& scene) {
    const std::string remedy = "Are its files on a disk that all hosts share, or an old copy on one of them?";
    std::vector<Common> all;
    for (const auto& [key, value] : scene_identity(scene)) all.push_back({key, hash_of(value), remedy});
    for (const BodySpec& body : scene.bodies)
        if (body.shape == BodyShape::table) all.push_back({"the bytes of " + body.file, body.table_hash, remedy});
    for (const GaugeSpec& gauge : scene.hazard.gauges)
        all.push_back({"hazard.gauges", hash_of(fmt::format("{} {} {}", gauge.name, gauge.x, gauge.y)), remedy});
    if (!scene.hazard.path.empty())
        all.push_back({"hazard.path", hash_of(fmt::format("{}", scene.hazard.path)), remedy});
    return all;
}

}  // namespace

Scene read_agreed(const Comm& comm, const Options& options, const std::function<void(const Scene&)>& admit) {
    const std::vector<std::string> sets = all_sets(options);
    agree_on(
        comm, options.scene,
        {{"the commit of the program", hash_of(commit_text), "Is one build installed on all hosts?"},
         {"what --set says", hash_of(fmt::format("{}", fmt::join(sets, "\n"))), "Start all ranks with the same words?"},
         {"what --allow-change says", hash_of(fmt::format("{}", fmt::join(options.allow_changes, "\n"))),
          "Start all ranks with the same words?"}});
    std::string text;
    agree_input(comm, [&] {
        if (comm.is_root()) text = read_scene_file(options.scene);
    });
    text = comm.broadcast(text);
    CodeRights rights{options.allow_code, CompileCache(kernel_cache_folder(options.kernel_cache))};
    if (comm.is_root() && !options.quiet)
        rights.tell = [](const std::string& words) { fmt::print(stderr, "{}\n", words); };
    Scene scene;
    std::vector<Common> values;
    agree_input(comm, [&] {
        scene = parse_scene(options.scene, text, sets, admit, rights);
        values = values_of(scene);
    });
    agree_on(comm, options.scene, values);
    return scene;
}

}  // namespace moraine
