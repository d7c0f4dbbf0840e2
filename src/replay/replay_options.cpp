#include "replay/replay_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/program_options.hpp>
#include <charconv>
#include <cmath>
#include <sstream>

#include "core/data/error.hpp"
#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

namespace po = boost::program_options;

/// The options as words: lists are taken apart afterwards.
struct Words {
    std::string ranks, partitioners, triggers, calibrate;
};

[[noreturn]] void refuse_argument(const std::string& problem, const std::string& why, const std::string& suggestion) {
    throw InputError(fmt::format("{} ({}). {}", problem, why, suggestion));
}

po::options_description visible(ReplayOptions& o, Words& w) {
    po::options_description options("replay");
    const auto add = [&](const char* name, const char* value, auto* target, const char* what) {
        options.add_options()(name, po::value(target)->value_name(value), what);
    };
    add("ranks", "P,P,...", &w.ranks, "ranks to predict for (default: 4,16,64,... as far as there are blocks)");
    add("partitioner", "A,B,...", &w.partitioners, "default: all that need no library");
    add("trigger", "A,B,...", &w.triggers, "never, every, threshold, planned (default: that of the run)");
    options.add_options()("sleep", po::bool_switch(&o.sleep),
                          "as if numerics.sleep had been on, of a run recorded without (default: as it ran)");
    options.add_options()("regret", po::bool_switch(&o.regret),
                          "compare all triggers with the best times to repartition, known afterwards");
    add("calibrate", "DIR,DIR,...", &w.calibrate, "other runs on the same machine, whose times count as well");
    add("latency", "SECONDS", &o.latency, "of a message (default: 2e-6)");
    add("bandwidth", "BYTES/S", &o.bandwidth, "of a rank, out (default: 5e9)");
    add("ranks-per-host", "N", &o.ranks_per_host,
        "ranks in a row on one host; --latency and --bandwidth are then those between hosts (default: no hosts)");
    add("latency-within", "SECONDS", &o.latency_within, "of a message within a host (default: as between)");
    add("bandwidth-within", "BYTES/S", &o.bandwidth_within, "of a rank within its host (default: as between)");
    add("every", "N", &o.every, "take every N-th imbalance check only (default: 1)");
    add("last-step", "N", &o.last_step, "ignore what was recorded after that step");
    add("refine", "K", &o.refine, "as if cells were 2^K times smaller, with as many particles in each block");
    add("output", "FILE", &o.output, "table to write (default: RUN_DIR/replay.csv)");
    return options;
}

/// Words between commas; none may be empty.
std::vector<std::string> split(const char* option, const std::string& list) {
    std::vector<std::string> parts(1);
    for (const char c : list)
        if (c == ',')
            parts.emplace_back();
        else
            parts.back() += c;
    for (const std::string& part : parts)
        if (part.empty())
            refuse_argument(fmt::format("{} {}", option, quote(list)), "nothing stands where a word should",
                            "Write words with a comma between them, or leave the option out?");
    return parts;
}

std::vector<int> ranks_of(const std::string& list) {
    std::vector<int> ranks;
    for (const std::string& word : split("--ranks", list)) {
        int value = 0;
        const auto end = std::from_chars(word.data(), word.data() + word.size(), value);
        if (end.ec != std::errc() || end.ptr != word.data() + word.size() || value < 1)
            refuse_argument("--ranks " + list, fmt::format("{} is not a number of ranks", quote(word)),
                            "Write whole numbers above 0, as in --ranks 4,16,64?");
        ranks.push_back(value);
    }
    return ranks;
}

const SceneKey& key_of_balance(const std::string& name) {
    return key_of(scene_rows(), "balance", name);
}

std::vector<std::string> choices_of(const char* option, const std::string& list,
                                    const std::vector<std::string>& choices) {
    std::vector<std::string> words = split(option, list);
    for (const std::string& word : words)
        if (std::find(choices.begin(), choices.end(), word) == choices.end())
            refuse_argument(fmt::format("{} {}", option, word), "must be one of " + listed(choices),
                            suggest(word, choices));
    return words;
}

void take_lists(const po::variables_map& given, const Words& w, ReplayOptions& o) {
    if (given.count("ranks")) o.ranks = ranks_of(w.ranks);
    if (given.count("partitioner"))
        o.partitioners = choices_of("--partitioner", w.partitioners, key_of_balance("partitioner").choices);
    if (given.count("calibrate")) o.calibrate = split("--calibrate", w.calibrate);
    if (!given.count("trigger")) return;
    const std::vector<std::string>& triggers = key_of_balance("trigger").choices;
    for (const std::string& name : choices_of("--trigger", w.triggers, triggers))
        o.triggers.push_back(
            static_cast<Trigger>(std::find(triggers.begin(), triggers.end(), name) - triggers.begin()));
}

/// `given`: the options that were.
void check_hosts(const po::variables_map& given, const ReplayOptions& o) {
    if (given.count("ranks-per-host") && o.ranks_per_host < 1)
        refuse_argument(fmt::format("--ranks-per-host {}", o.ranks_per_host), "must be at least 1", "Leave it out?");
    for (const char* name : {"latency-within", "bandwidth-within"})
        if (given.count(name) && o.ranks_per_host < 1)
            refuse_argument(fmt::format("--{}", name), "without --ranks-per-host there are no hosts",
                            "Try --ranks-per-host 4?");
    if (given.count("latency-within") && (!(o.latency_within >= 0) || !std::isfinite(o.latency_within)))
        refuse_argument(fmt::format("--latency-within {}", o.latency_within), "must be seconds, 0 or more",
                        "Try 1e-6?");
    if (given.count("bandwidth-within") && (!(o.bandwidth_within > 0) || !std::isfinite(o.bandwidth_within)))
        refuse_argument(fmt::format("--bandwidth-within {}", o.bandwidth_within), "must be bytes per second above 0",
                        "Try 1e11?");
}

void check_numbers(const ReplayOptions& o) {
    if (!(o.latency >= 0) || !std::isfinite(o.latency))
        refuse_argument(fmt::format("--latency {}", o.latency), "must be seconds, 0 or more", "Try 2e-6?");
    if (!(o.bandwidth > 0) || !std::isfinite(o.bandwidth))
        refuse_argument(fmt::format("--bandwidth {}", o.bandwidth), "must be bytes per second above 0", "Try 5e9?");
    if (o.every < 1) refuse_argument(fmt::format("--every {}", o.every), "must be at least 1", "Did you mean 1?");
    if (o.refine < 0 || o.refine > 6)
        refuse_argument(fmt::format("--refine {}", o.refine), "must be 0 to 6", "Did you mean 1?");
    if (o.last_step < 0)
        refuse_argument(fmt::format("--last-step {}", o.last_step), "must not be negative", "Leave it out?");
}

}  // namespace

ReplayOptions parse_replay(const std::vector<std::string>& words) {
    ReplayOptions o;
    Words w;
    std::vector<std::string> directories, names;
    const po::options_description shown = visible(o, w);
    for (const auto& option : shown.options()) names.push_back("--" + option->long_name());
    po::options_description all;
    all.add(shown).add_options()("directory", po::value(&directories));
    po::positional_options_description positional;
    positional.add("directory", -1);
    po::variables_map map;
    try {
        namespace style = po::command_line_style;
        po::store(po::command_line_parser(words)
                      .options(all)
                      .positional(positional)
                      .style(style::allow_long | style::long_allow_adjacent | style::long_allow_next)
                      .run(),
                  map);
        po::notify(map);
    } catch (const po::unknown_option& e) {
        refuse_argument(e.get_option_name(), "moraine replay has no such option", suggest(e.get_option_name(), names));
    } catch (const po::error& e) {
        refuse_argument("the command line", e.what(), "See moraine --help?");
    }
    if (directories.size() != 1)
        refuse_argument(fmt::format("{} run directories", directories.size()), "replay takes one",
                        "Try moraine replay runs/slurry_runout?");
    o.directory = directories[0];
    take_lists(map, w, o);
    check_numbers(o);
    check_hosts(map, o);
    return o;
}

std::string replay_help() {
    ReplayOptions o;
    Words w;
    std::ostringstream out;
    out << visible(o, w);
    return out.str();
}

}  // namespace moraine
